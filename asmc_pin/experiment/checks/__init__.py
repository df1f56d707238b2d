"""What is wrong with an experiment: every mistake at once, each with the path of its key and how to mend it.

Takes the tables of a file, or objects made of them; gives `Mistake`s. May import what `asmc_pin.experiment` may.
"""
