"""The page of an identification: how right a URDF is by a log, joint by joint, in words and figures.

Takes an `Identification`; gives HTML or Markdown with figures. May import what `pages` may.
"""
