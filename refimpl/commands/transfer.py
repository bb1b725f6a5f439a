"""`refimpl transfer`: a clip in another style, on its own skeleton, at its own rate."""

import argparse
import sys
from typing import Any

import numpy as np

from ..fast import networks
from ..holden2016 import bridge, own, search
from ..styles.box import STYLES_SAID, find_style
from ..styles.files import load_manifold
from ..holden2017.transfer import transfer
from ..motion.body import carries_hips, guess_unit, read_take, seen, standing_height
from ..motion.bvh import write_bvh
from ..motion.features import bone_lengths, path_length
from ..motion.canonical import PARTS
from ..motion.clip import plus_offsets
from ..motion.joints import SLOT, MappingError
from ..motion.part import frames_of, part_of
from ..motion.skeleton import FASTEST, SLOWEST
from .options import (InputPath, OutputClip, OutputPage, OutputPath, OutputPicture, add_reading,
                      number, parts, reading, whole, write_report)
from .progress import Progress

DESCRIPTION = """A clip in another style, on its own skeleton, at its own rate: by a trained
network (the system of 2017), or by an optimisation that needs no training for a new style (that of
2016): --method optimise --content CLIP.bvh --style S.bvh with either --manifold M.npz, a loss
network of this package, or --network and --preprocess, the two files of the authors' own network or
of `refimpl train-2016`. --form own is this package's form of the search, --form coded the one of
the 2016 code, statement by statement, which needs the two files, takes the whole clip for its
content and the first 240 rows of one clip for its style; the code locks no feet: --raw shows what
it shows. With --from and --to a part of the clip is written, and nothing else; its floor, its
contacts and what the method sees before and after it are those of the whole clip (--form coded
sees the part alone). What is written begins where the content is at that time."""
_FORMS = ("own", "coded")


def add_commands(commands: Any) -> None:
    """Add `transfer` to the subparsers of the program."""
    command = commands.add_parser("transfer", description=DESCRIPTION)
    command.add_argument("style_file", metavar="STYLE", nargs="?", type=InputPath,
                         help=f"a style in the box ({', '.join(STYLES_SAID)}), or what `refimpl "
                         "train-style` wrote")
    command.add_argument("clip", metavar="CLIP.bvh", nargs="?", type=InputPath, help="the content")
    command.add_argument("-o", "--output", metavar="OUT.bvh", type=OutputClip, required=True)
    add_reading(command)
    command.add_argument("--from", dest="begin", metavar="SECONDS", type=number(least=0),
                         default=0.0, help="write the clip from here on "
                         "(default: from its first row)")
    command.add_argument("--to", dest="end", metavar="SECONDS", type=number(above=0),
                         help="and until here, both counted from the clip's first row; the whole "
                         "clip is stylised for it (default: to its last)")
    command.add_argument("--raw", action="store_true",
                         help="what the method gives as it is, jitter and sliding feet included")
    command.add_argument("--no-projection", action="store_true",
                         help="T(I) alone, without the manifold projection P")
    command.add_argument("--own-pace", action="store_true",
                         help="walk the content's path as fast as the result's feet step")
    command.add_argument("--strength", type=number(least=0, most=100), default=1.0, metavar="S",
                         help="how much of the change: 0 is the content, 1 the style "
                              "(default: %(default)g)")
    command.add_argument("--only", type=parts, default=(), metavar="A,B",
                         help=f"change these parts alone, of {', '.join(PARTS)}; with legs the "
                         "hips sink as far as planted feet need")
    command.add_argument("--fps", type=number(least=SLOWEST, most=FASTEST), metavar="FPS",
                         help="frames a second of the result (default: the clip's own)")
    command.add_argument("--plot", metavar="OUT.png", type=OutputPicture,
                         help="draw content and result, a pose at a time, from the side")
    command.add_argument("--animate", metavar="OUT.html", type=OutputPage,
                         help="a page with a player of content and result, for a browser")
    command.add_argument("--json", metavar="FILE", type=OutputPath,
                         help="write what was done as JSON")
    command.add_argument("--method", choices=("network", "optimise"), default="network",
                         help="(default: %(default)s)")
    group = command.add_argument_group("with --method optimise")
    group.add_argument("--content", metavar="CLIP.bvh", type=InputPath, help="the content")
    group.add_argument("--style", metavar="S.bvh", nargs="+", type=InputPath,
                       help="one clip or more in the style")
    group.add_argument("--manifold", metavar="M.npz", type=InputPath,
                       help="what `refimpl train-autoencoder` wrote")
    group.add_argument("--network", metavar="N.npz", type=InputPath,
                       help="a network of 2016: the authors' network_core.npz, or what "
                       "`refimpl train-2016` wrote")
    group.add_argument("--preprocess", metavar="P.npz", type=InputPath,
                       help="its normaliser, like the authors' preprocess_core.npz")
    group.add_argument("--form", choices=_FORMS,
                       help="of the search: this package's or the 2016 code's "
                       f"(default: {_FORMS[0]})")
    group.add_argument("--weight-style", type=number(least=0, below=1), metavar="S",
                       help="against 1 - S for the content (default: "
                       f"{own.STYLE_SHARES['groups']}; coded and with the 2016 normaliser "
                       f"{search.AMOUNT:g} / {1 + search.AMOUNT:g})")
    group.add_argument("--start", choices=("noise", "content"),
                       help=f"where the own search begins (default: {own.Settings.start})")
    group.add_argument("--iterations", type=whole(0), metavar="N",
                       help=f"of the first search (default: {own.Settings.iterations})")
    group.add_argument("--seed", type=whole(0), metavar="N", help="of the noise (default: 0)")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Stylise a clip, write it and what else was asked for, and print how far its path strays.

    A ValueError says which options do not belong together or what cannot be read.
    """
    optimised = arguments.method == "optimise"
    content = _check_method(arguments)
    overrides, how = reading(arguments)
    if optimised:
        network = (bridge.read(arguments.network, arguments.preprocess)
                   if arguments.network else None)
        manifold = load_manifold(arguments.manifold) if network is None else None
        exemplars = [_exemplar(path, overrides) for path in arguments.style]
        name = " ".join(arguments.style)
    else:
        style = find_style(arguments.style_file)
        name = repr(style.name)
    progress = Progress(3, "part")                               # which take about equally long
    take = read_take(content, overrides, **how)
    progress.step("read")
    frames = frames_of(take, arguments.begin, arguments.end)
    way = path_length(seen(take).features[frames])
    if optimised:
        result = _optimise(arguments, take, exemplars, manifold, network)
    else:
        result = transfer(take, style, projected=not arguments.no_projection,
                          clean=not arguments.raw, own_pace=arguments.own_pace,
                          networks=networks, **_back(arguments))
    progress.step("stylised")
    result = part_of(take, result, arguments.begin, arguments.end)
    positions = take.positions[frames]
    write_bvh(arguments.output, plus_offsets(result.clip, -1.0) if arguments.positions == "add"
              else result.clip)
    unit = guess_unit(standing_height(bone_lengths(take.positions)))
    # The distance between the paths that were written and read.
    written, wanted = (p[:, SLOT["Hips"], [0, 2]] for p in (result.positions, positions))
    apart = np.linalg.norm(written - wanted, axis=-1)
    mean, largest = float(apart.mean()), float(apart.max())
    stays = ("" if carries_hips(take) else "; the file has no joint with three position channels "
             "to carry it: it stays where the content is")
    print(f"{arguments.output}: {result.clip.frames} frames at "
          f"{result.clip.fps:g} frames/s in style {name}; its "
          f"path leaves the content's by {mean:.3g} on average, {largest:.3g} at most, of a way of "
          f"{way:.3g} ({unit}){stays}")
    for warning in result.warnings:
        print(f"refimpl: warning: {content}: {warning}", file=sys.stderr)
    if arguments.json:
        row = {"content": content, "style": name, "result": arguments.output,
               "frames": result.clip.frames, "fps": result.clip.fps, "mean path error": mean,
               "largest path error": largest, "way": way, "unit": unit,
               "strangeness": None if np.isnan(result.strangeness) else result.strangeness,
               "warnings": "; ".join(result.warnings)}
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "transfer", settings, [row])
    if arguments.plot or arguments.animate:
        _draw(positions, result, arguments.plot, arguments.animate, unit)


def _optimise(arguments, take, exemplars, manifold, network):
    chosen = {"style": arguments.weight_style, "start": arguments.start,
              "iterations": arguments.iterations}
    chosen = {key: value for key, value in chosen.items() if value is not None}
    common: dict[str, Any] = {"clean": not arguments.raw, "seed": arguments.seed or 0,
                              **_back(arguments)}
    if arguments.form == "coded":
        if "style" in chosen:
            share = chosen.pop("style")
            chosen["amount"] = share / (1 - share)
        return bridge.transfer(take, exemplars[0].positions, network, **chosen, **common)
    return own.transfer(take, exemplars, manifold or network.manifold(),
                        settings=own.Settings(**chosen), networks=networks, **common)


def _back(arguments):
    """How the change comes back to the clip."""
    return {"strength": arguments.strength, "only": arguments.only, "fps": arguments.fps}


def _exemplar(path, overrides):
    """A clip in the style; the mapping file is for it, too, if it needs one."""
    try:
        return read_take(path)
    except MappingError:
        if not overrides:
            raise
        return read_take(path, overrides)


def _check_method(arguments):
    """Every option of the other method is refused, every missing one named.
    ->  path of the content
    """
    of_network = {
        "STYLE": arguments.style_file, "CLIP.bvh": arguments.clip,
        "--no-projection": arguments.no_projection or None,
        "--own-pace": arguments.own_pace or None}
    of_optimise = {f"--{name}": getattr(arguments, name.replace("-", "_"))
                   for name in ("content", "style", "manifold", "network", "preprocess", "form",
                                "weight-style", "start", "iterations", "seed")}
    optimised = arguments.method == "optimise"
    of_2016 = arguments.network or arguments.preprocess or arguments.form == "coded"
    model = ("--network", "--preprocess") if of_2016 else ("--manifold",)
    needed = ("--content", "--style", *model) if optimised else ("STYLE", "CLIP.bvh")
    for name, value in (of_network if optimised else of_optimise).items():
        if value is not None:
            hint = {"STYLE": "leave it out; the style is --style S.bvh",
                    "CLIP.bvh": "give the clip with --content"}.get(name, "leave it out")
            raise ValueError(f"transfer: found {name} with --method {arguments.method}, which has "
                             "no use for it; " + (hint if optimised else "try --method optimise"))
    missing = [name for name in needed if (of_optimise if optimised else of_network)[name] is None]
    if missing:
        raise ValueError(f"transfer: found no {', '.join(missing)}, needed {', '.join(needed)} "
                         f"with --method {arguments.method}")
    if of_2016 and arguments.manifold:
        raise ValueError("transfer: found --manifold beside a network of 2016, needed one of them; "
                         "the coded form is for the latter: leave --manifold out")
    if arguments.form == "coded" and arguments.start:
        raise ValueError("transfer: found --start with --form coded, which always begins at noise; "
                         "leave it out")
    if arguments.form == "coded" and len(arguments.style) > 1:
        raise ValueError(f"transfer: found {len(arguments.style)} clips for --style with --form "
                         "coded, needed one, as the 2016 code takes")
    return arguments.content if optimised else arguments.clip


def _draw(content, result, picture, animation, unit):
    """The picture and the player of a transfer."""
    motions = {"content": content, "result": result.positions}
    if picture:
        from ..pictures import plot
        plot.save(plot.strip(motions, unit=unit), picture)
        print(f"{picture}: content and result")
    if animation:
        from ..pictures.player import write_player
        size = write_player(animation, motions, unit=unit)
        print(f"{animation}: content and result in a player, {size / 1000:.0f} kB")
