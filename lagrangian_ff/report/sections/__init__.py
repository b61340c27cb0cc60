"""Parts of a page: each file turns what was found into text and figures."""
