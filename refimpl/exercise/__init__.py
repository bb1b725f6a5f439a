"""What the check cell of a notebook calls: your function is judged element by element, told where
it is wrong and what kind of mistake that looks like, or, as long as it is not written, replaced.

| module | question |
| --- | --- |
| `trial` | is the answer right, and which function does the notebook go on with? |
| `answers` | what was handed back, and is it the right thing? |
| `lines` | how is a case drawn, and a crash told? |
| `mistakes` | which mistake would give just these numbers? |
| `rivals` | what do common mistakes make of an answer, and of what is asked? |
| `behaviour` | where is it wrong, what does it listen to, what has it lost? |
| `repairs` | which single change to its text would make it right? |
| `changes` | what may stand in a place of a text instead of what stands there? |
"""

from .trial import attempt, gradient_by_steps as slopes

__all__ = ["attempt", "slopes"]
