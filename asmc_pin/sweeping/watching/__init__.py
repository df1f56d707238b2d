"""Watching what is being computed: how far a sweep is, and a comparison as soon as it is whole.

Takes the folder of a result that may not be there yet; gives a page that is served, and made anew at each look. May
import what `sweeping` may; computes nothing.
"""
