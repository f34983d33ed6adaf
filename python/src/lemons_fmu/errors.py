"""What goes wrong with FMUs."""


class FmuError(Exception):
    """The FMU refused a call or failed (the message is that of the FMU), or its file is not valid."""
