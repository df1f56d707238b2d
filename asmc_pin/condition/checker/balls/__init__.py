"""The third leg: rigorous ball arithmetic from the URDF's decimals to the condition itself.

Takes the URDF's numbers and points or small boxes; gives enclosures of the condition. Knows nothing of the bounds of
`boxes`, so that neither can hide the other's mistakes.
"""
