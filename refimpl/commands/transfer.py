"""`refimpl transfer`: a clip in another style, on its own skeleton, at 60 frames a second."""

from ..holden2017.measure import path_error
from ..holden2017.model import load_style
from ..holden2017.transfer import transfer
from ..motion.bvh import write_bvh
from ..motion.joints import read_mapping
from ..motion.take import bone_lengths, guess_unit, read_take, standing_height
from ..storage import check_writable


def add_commands(commands):
    command = commands.add_parser("transfer", help="stylise a BVH clip", description=__doc__)
    command.add_argument("style", metavar="STYLE.npz", help="what `refimpl train-style` wrote")
    command.add_argument("clip", metavar="CLIP.bvh", help="the content")
    command.add_argument("-o", "--output", metavar="OUT.bvh", required=True)
    command.add_argument("--mapping", metavar="FILE.csv", help="lines slot,joint for a skeleton with other names")
    command.add_argument("--raw", action="store_true", help="the network's output as it is, feet that slide included")
    command.add_argument("--no-projection", action="store_true", help="T(I) alone, without the manifold projection P")
    command.add_argument("--plot", metavar="OUT.png", help="draw content and result as in the paper's figure 3")
    command.add_argument("--animate", metavar="OUT.html", help="an animation of content and result for a browser")
    command.set_defaults(run=run)


def run(arguments):
    for path in (arguments.output, arguments.plot, arguments.animate):
        if path:
            check_writable(path)
    style = load_style(arguments.style)
    take = read_take(arguments.clip, read_mapping(arguments.mapping) if arguments.mapping else None)
    result = transfer(take, style, projected=not arguments.no_projection, planted=not arguments.raw)
    write_bvh(arguments.output, result.clip)
    unit = guess_unit(standing_height(bone_lengths(take.positions)))
    mean, largest = path_error(result.features, take.features)
    print(f"{arguments.output}: {result.clip.frames} frames at 60 frames/s in style {style.name!r}; "
          f"its path leaves the content's by {mean:.3g} on average, {largest:.3g} at most ({unit})")
    if arguments.plot or arguments.animate:
        draw(take.positions, result, arguments.plot, arguments.animate, unit)


def draw(content, result, picture, animation, unit):
    """The picture and the animation of a transfer."""
    from .. import animate, plot
    motions = {"content": content, "result": result.positions}
    if picture:
        plot.save(plot.strip(motions, unit=unit), picture)
        print(f"{picture}: content and result")
    if animation:
        frames = animate.animation_html(motions, 60.0, animation)
        print(f"{animation}: {frames} pictures")
