"""One function a command: options in, a verb of the package called, text or JSON out. Importing it registers them."""
