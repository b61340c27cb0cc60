"""The workbench: a page on which recordings become a model, and the model shows what it lacks.

`session` is what lies on disk, `settings` what the user chose, `jobs` and `looking` the work in
processes, `traces` what is drawn of a comparison, `server` the page's other end, `live` a robot
that it is attached to, `page/` the page itself.
"""
