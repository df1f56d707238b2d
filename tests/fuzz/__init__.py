"""Hostile inputs for the whole command line, made from a seed, and what must hold whatever they are.

In: a seed, a kind and an index. Out: findings, each with the line that makes it again. The generators know the shape of
an input and nothing of the package, but for what makes the sound inputs that they start from (`corpus`).
"""
