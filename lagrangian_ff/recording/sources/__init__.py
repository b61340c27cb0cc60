"""The kinds of file a recording is read from; `files` lists them."""
