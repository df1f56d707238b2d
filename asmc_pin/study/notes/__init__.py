"""What is said of a study besides its figures: warnings, notes, and Lemma 1 along the reference.

Takes an experiment, its plant and what was run; gives lines and ranges. May import what `study` may.
"""
