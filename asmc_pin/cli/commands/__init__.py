"""One function a command: options in, a verb of the package called, text or JSON out.

Every file here is imported when the command line starts, and registers its commands. May import all rooms, heavy ones
within a function only, so that help stays quick.
"""
