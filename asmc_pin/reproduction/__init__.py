"""The tables and figures of Baek, Jin, Han (2016) again: what was printed, how it can be read, what comes out here.

Takes the shipped experiments; gives docs/reproduction.md and its page. May import all rooms but `cli`.
"""
