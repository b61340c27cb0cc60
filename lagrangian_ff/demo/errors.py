"""What can go wrong in the demo, in the user's words."""

from lagrangian_ff.errors import UserError


class DemoError(UserError):
    """A node did not do what was asked of it; the text says which, and where its log is."""


class LostRunError(DemoError):
    """A run of the arm came to nothing; it may be done again."""
