"""The process that identifies: `python -m lagrangian_ff.nodes.recorder.work ORDER`.

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
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.nodes.recorder.order import Order
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Conditioning, condition, load

PREPARATION = 0.1  # share of the progress that reading takes


def identify_bags(order: Order, progress: Progress) -> dict[str, Any]:
    """From bags to a model file, by the code the command line uses; the record.

    Raises:
        UserError: a recording or a setting cannot be used.
    """
    conditioning = Conditioning(
        bandwidth=order.bandwidth,
        effort_scale=order.effort_scale,
        effort_offset=order.effort_offset,
    )
    motions = []
    for number, bag in enumerate(order.bags):
        progress(PREPARATION * number / len(order.bags), f"reading {Path(bag).name}")
        recording = load(bag, topic=order.topic, joints=order.joints or None)
        motions.append(condition(recording, conditioning))
    found = identify(
        motions,
        Settings(model=order.model, train=order.train, samples=order.samples),
        lambda fraction, label: progress(PREPARATION + (1 - PREPARATION) * fraction, label),
    )
    found.model.save(Path(order.output))
    return dict(found.record)


def main() -> int:
    """Carry out the order on the command line; the exit code."""
    os.nice(5)  # recording and control come first
    order = Order.from_json(sys.argv[1])
    threading.Thread(target=_end_with_the_node, daemon=True).start()
    try:
        record = identify_bags(
            order, lambda fraction, label: _tell({"progress": fraction, "label": label})
        )
    except UserError as error:
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
