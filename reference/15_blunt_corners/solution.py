"""The closed form of README.md."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))



def solution():
    """Springs without dampers and friction give back what they take."""
    return {f"{k}.speed": 1.0 for k in range(4)}
