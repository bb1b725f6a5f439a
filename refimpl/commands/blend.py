"""`refimpl observe` and `refimpl blend`: what a clip looks like, and one between two clips."""

import argparse
from pathlib import Path
import sys
from typing import Any

from ..motion.body import make_take
from ..motion.bvh import read_bvh, write_bvh
from ..motion.clip import Clip
from ..torresani2006.align import HIGHEST, LOWEST
from ..torresani2006.blend import blend_clips
from ..torresani2006.efforts import BY_SWINGS, BY_PATHS, seen_alone
from ..torresani2006.observe import EFFORTS, POLES
from ..torresani2006.poses import fit_body, fragment_of
from .options import InputPath, OutputClip, OutputPath, write_report
from .progress import table


def add_commands(commands: Any) -> None:
    """Add `observe` and `blend` to the subparsers of the program."""
    command = commands.add_parser(
        "observe",
        description="Flow, weight and time of clips as two computed observers see them, by how "
        "bones swing and by the paths of joints. " + "; ".join(
            f"{effort}: {poles}" for effort, poles in zip(EFFORTS, POLES)) + ". 0 is what is usual "
        "for the embedded performers: compare clips of one action. No analyst has been asked.")
    command.add_argument("clips", metavar="CLIP.bvh", nargs="+", type=InputPath)
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write the rows as JSON")
    command.set_defaults(run=run_observe)
    command = commands.add_parser(
        "blend",
        description="Blend two clips of one skeleton and one action in space and time (section 5 "
        "of Torresani 2006), without pops.")
    command.add_argument("first", metavar="A.bvh", type=InputPath)
    command.add_argument("second", metavar="B.bvh", type=InputPath)
    command.add_argument("--alpha", type=float, default=0.5, metavar="X",
                         help=f"0 for A, 1 for B, from {LOWEST:g} to {HIGHEST:g} "
                         "(default: %(default)s)")
    command.add_argument("-o", "--output", metavar="OUT.bvh", type=OutputClip, required=True)
    command.set_defaults(run=run_blend)


def read_warned(path: str) -> Clip:
    """A clip, with a warning for each reason to doubt that a body moves in it. A ValueError says
    what cannot be read.
    """
    clip = read_bvh(path)
    try:
        said = make_take(clip).doubts
    except ValueError:                                           # another body than that of 2017
        said = ()
    for why in said:
        print(f"refimpl: warning: {path}: {why}", file=sys.stderr)
    return clip


def run_observe(arguments: argparse.Namespace) -> None:
    """Print and write two rows a clip. A ValueError says what cannot be read or observed."""
    rows = []
    for path in arguments.clips:
        clip = read_warned(path)
        body = fit_body([clip])
        fragment = fragment_of(clip, body, Path(path).stem, fps=clip.fps)
        for sight in (BY_SWINGS, BY_PATHS):
            seen = seen_alone(fragment, body, sight).tolist()
            rows.append({"clip": path, "observer": sight.name, **dict(zip(EFFORTS, seen))})
    print("\n".join(table([list(rows[0]), *([f"{x:.2f}" if isinstance(x, float) else x
                                             for x in row.values()] for row in rows)])))
    if arguments.json:
        write_report(arguments.json, "observe", {"clips": arguments.clips}, rows)


def run_blend(arguments: argparse.Namespace) -> None:
    """Write a blend and print what it took. A ValueError says what cannot be blended."""
    clip, made, before, after = blend_clips(read_warned(arguments.first),
                                            read_warned(arguments.second), arguments.alpha)
    write_bvh(arguments.output, clip)
    path = "limited in slope" if made.limited else "as equation 3 has it (lengths too different)"
    drawn = {0.0: "", 0.5: ", drawn half-way to the straight line",
             1.0: ", drawn to the straight line"}[made.straight]
    print(f"{arguments.output}: {clip.frames} frames; time curve {path}{drawn}"
          + (f"; {made.slower:.2f} times slower" if made.slower > 1 else "")
          + f"; peak acceleration {made.peak:.2f} of the larger parent's; planted feet slide "
          f"{before:.2f}, now {after:.2f} a second")
