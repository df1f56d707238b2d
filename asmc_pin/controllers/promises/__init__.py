"""What the source of a law claims of a run, as arithmetic on what happened, joint by joint.

Takes a `History` of one trial, of the true motion; gives `Findings`, which the monitors turn into verdicts. May import
numpy, typing and errors.
"""
