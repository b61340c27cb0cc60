"""The pages, one file each: a title that says the verdict, and the sections listed once."""
