"""Stills and films of a replay for papers and talks, taken by a headless Chromium of this machine.

Takes a page of the viewer; gives a PNG or an MP4. May import what `viewer` may; a Chromium, and PyAV for films, are
asked for only when a picture is taken.
"""
