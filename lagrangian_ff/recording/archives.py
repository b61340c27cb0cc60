"""What reading a damaged .npz archive raises."""

import tokenize
import zipfile
import zlib

DAMAGED = (
    ValueError, TypeError, KeyError, EOFError, RuntimeError, MemoryError, SyntaxError,
    tokenize.TokenError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""A flipped bit can reach the zip's flags (RuntimeError), and the text that says an array's shape:
it then cannot be parsed (SyntaxError, TokenError), or asks for more memory than there is."""
