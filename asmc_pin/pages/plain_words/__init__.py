"""The first screen of a report, in plain words: what was compared, who won, what to do next, what the terms mean.

Takes the summary and the claims of a comparison; gives sentences, the next command, and explanations of terms. May
import what `pages` may; draws nothing.
"""
