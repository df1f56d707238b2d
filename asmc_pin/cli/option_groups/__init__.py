"""Options that several commands share and that belong together: one list of them, in one place, for every command.

Takes the words of a command; gives what the functions of the package take. May import what `cli` may, heavy rooms
within a function only.
"""
