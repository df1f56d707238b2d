"""Loading an arm."""
