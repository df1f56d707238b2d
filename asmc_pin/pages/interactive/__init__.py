"""Interactive figures of a run: curves of every joint, thinned honestly, drawn in the browser by an inlined BokehJS.

Takes the dataset of a comparison; gives an element and its scripts. May import what `pages` may; Bokeh is there for its
script alone and is never imported.
"""
