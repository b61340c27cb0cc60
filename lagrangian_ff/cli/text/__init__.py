"""How findings are told to people: tables, equations, verdicts. Records in, lines out."""
