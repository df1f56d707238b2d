"""What a link looks like: meshes, shapes and colours of a URDF, thinned and attached to their joints.

Takes an arm with its visuals; gives bodies for a scene. A drawing problem is a warning and a grey link. May import
`arms` and what is open to all.
"""
