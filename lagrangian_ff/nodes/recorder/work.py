"""The process that computes: `python -m lagrangian_ff.nodes.recorder.work ORDER`.

A process of its own, because compiled code that holds the interpreter would hold up the
recording, and because whatever happens to it the node lives on. It writes one JSON object a
line: {"progress", "label"} while it works, {"result"} or {"error"} at the end. It ends when its
standard input does, so that it does not outlive a killed node.
"""

import json
import os
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.recorder.order import Order, Task
from lagrangian_ff.progress import Progress


def program(task: Task) -> Callable[[Order, Progress], dict[str, Any]]:
    """What carries a task out; imported only now, because an identification needs no page."""
    if task is Task.IDENTIFY:
        from lagrangian_ff.nodes.recorder.tasks.identifying import identify_bags

        return identify_bags
    if task is Task.COMPARE:
        from lagrangian_ff.nodes.recorder.tasks.comparing import compare_bags

        return compare_bags
    if task is Task.DIAGNOSE:
        from lagrangian_ff.nodes.recorder.tasks.diagnosing import diagnose_bags

        return diagnose_bags
    from lagrangian_ff.nodes.recorder.tasks.adding import add_to_model

    return add_to_model


def main() -> int:
    """Carry out the order on the command line; the exit code."""
    os.nice(5)  # recording and control come first
    order = Order.from_json(sys.argv[1])
    threading.Thread(target=_end_with_the_node, daemon=True).start()
    try:
        record = program(order.task)(
            order, lambda fraction, label: _tell({"progress": fraction, "label": label})
        )
    except (UserError, OSError) as error:
        _tell({"error": str(error)})
        return 2
    except Exception as error:
        traceback.print_exc()
        _tell({"error": f"unexpected {type(error).__name__}: {error}"})
        return 1
    _tell({"result": record})
    return 0


def _tell(event: dict[str, Any]) -> None:
    print(json.dumps(event), flush=True)


def _end_with_the_node() -> None:
    sys.stdin.read()
    os._exit(3)


if __name__ == "__main__":
    sys.exit(main())
