"""Small help for sentences."""


def counted(number: int, thing: str) -> str:
    """`1 gap`, `2 gaps`."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"
