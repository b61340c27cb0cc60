"""Errors that a user can mend: their text is the whole message, shown without a traceback."""


class UserError(Exception):
    """Says what was expected, what came, where, and what to do, in the user's words.

    The command line prints it and ends with exit code 2; the nodes log it and go on.
    """


class RecordingError(UserError):
    """A recording that cannot be read or does not hold what the model needs."""


class TopicError(RecordingError):
    """A bag that has no topic of the name asked for."""


class ModelError(UserError):
    """A model that cannot be built, read, or used on these joints or motions."""


class ArmError(UserError):
    """A command the simulated arm cannot carry out: limits, collisions, unknown joints."""


class EffectError(UserError):
    """A physical effect that is unknown, does not load, or gives what an effect must not."""


class DemoError(UserError):
    """A node of the demo that failed; the text says which, and where its log is."""


class LostRunError(DemoError):
    """A run of the arm that was lost; it may be repeated."""


class ExportError(UserError):
    """A model that a format cannot hold, or a file that it cannot be written to."""
