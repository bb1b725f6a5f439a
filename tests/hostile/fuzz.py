"""Throw malformed files at every reader. `python -m tests.hostile.fuzz 200000 [folder of BVH
clips [number of the first]]`

Every input must be read or refused with one of the package's own errors, within a second of the
processor's time. Inputs come from a grammar (BVH with odd but legal and with broken parts) and from
mutations of whole files; the random numbers are fixed, so that a run can be repeated and a failure
found again by its number.
"""

from collections import Counter
import io
from pathlib import Path
import random
import sys
import tempfile
import time
import traceback

import numpy as np

from refimpl.holden2017.trained import Manifold, Style
from refimpl.styles.files import load_manifold, load_style, save_manifold, save_style
from refimpl.motion import bvh
from refimpl.embedded import walkers as synthetic
from refimpl.motion.clip import BVHError
from refimpl.motion.dataset import (LabelError, assemble, labels_from_file, load_dataset,
                                    save_dataset)
from refimpl.motion.features import FEATURES
from refimpl.motion.joints import BONES, MappingError, read_mapping
from refimpl.motion.mapping import map_clip
from refimpl.motion.windows import Normaliser
from refimpl.motion.body import make_take
from refimpl.storage import FormatError

SECONDS = 1.0
WORDS = (
    ("HIERARCHY ROOT JOINT End Site OFFSET CHANNELS MOTION Frames: Frame Time: { } 0 1 2 3 6 -1 "
     "1e5 1E-05 nan inf -inf 1e999 1_0 0x1 ١ . - + 9999999999 "
     "Xposition Yposition Zposition Xrotation Yrotation Zrotation Wrotation Hips LeftFoot # "
     "\ufeff \x00 \u2028 é").split(" ") + [" ", "\t", "\n", "\r", "\r\n"])


def grammar(rng):
    """A BVH text from its grammar, now and then with a part that is wrong."""
    def number():
        return (rng.choice(["0", "1", "-2.5", "1e1", "1E-05", ".5", "5.", "+3", "90"])
                if rng.random() < 0.97 else rng.choice(WORDS))

    def joint(depth, lines):
        name = (rng.choice(["Hips", "Left Arm", "a", "b:c", "é", f"j{rng.randrange(1000)}", ""])
                + (str(rng.randrange(10 ** 6)) if rng.random() < 0.9 else ""))
        space = rng.choice([" ", "\t", "  "])
        lines.append(f"{'ROOT' if depth == 0 else 'JOINT'}{space}{name}"
                     + ("" if rng.random() < 0.5 else "\n") + (" {" if rng.random() < 0.98 else ""))
        lines.append("OFFSET " + space.join(number()
                                            for _ in range(3 if rng.random() < 0.98
                                                           else rng.randrange(6))))
        count = rng.choice([0, 3, 3, 6])
        names = ((bvh.POSITION_CHANNELS if count == 6 else ())
                 + (tuple(rng.sample(bvh.ROTATION_CHANNELS, 3)) if count else ()))
        if count or rng.random() < 0.5:
            lines.append(f"CHANNELS {count if rng.random() < 0.98 else number()} "
                         + " ".join(names))
        width = len(names)
        for _ in range(rng.choice([0, 0, 1, 1, 2]) if depth < 5 else 0):
            width += joint(depth + 1, lines)
        if rng.random() < 0.4:
            lines.append("End Site\n{\nOFFSET 0 1 0\n}")
        lines.append("}" if rng.random() < 0.98 else "")
        return width
    lines = ["HIERARCHY"]
    width = joint(0, lines)
    frames = rng.randrange(1, 4)
    lines += ["MOTION",
              f"Frames:{rng.choice([' ', chr(9)])}{frames if rng.random() < 0.97 else number()}",
              f"Frame Time: {rng.choice(['0.0333333', '0.0166667', number()])}"]
    lines += [" ".join(number()
                       for _ in range(width if rng.random() < 0.98 else rng.randrange(width + 3)))
              for _ in range(frames if rng.random() < 0.98 else rng.randrange(4))]
    return rng.choice(["\n", "\n", "\r\n", "\r"]).join(lines) + rng.choice(["", "\n"])


def mutate_text(text, rng):
    for _ in range(rng.choice([1, 1, 2, 5])):
        at, length = rng.randrange(len(text) + 1), rng.choice([0, 1, 1, 5, 80])
        action = rng.randrange(4)
        if action == 0:
            text = text[:at] + rng.choice(WORDS) + text[at + length:]
        elif action == 1:
            text = text[:at] + text[at + length:]
        elif action == 2:
            text = text[:at] + text[at:at + length] * rng.choice([2, 3, 20]) + text[at:]
        else:
            text = text[:at]
    return text


def mutate_bytes(data, rng):
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        if not data:
            break
        at, length = rng.randrange(len(data)), rng.choice([1, 1, 4, 64])
        action = rng.randrange(4)
        if action == 0:
            data[at:at + length] = rng.randbytes(length)
        elif action == 1:
            del data[at:at + length]
        elif action == 2:
            data[at:at] = data[at:at + length]
        else:
            del data[at:]
    return bytes(data)


def rewrite_npz(data, rng):
    """A well-formed archive with one array or the header changed: what a checksum does not notice.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    name = rng.choice(list(arrays))
    action = rng.randrange(6)
    if name == "header":
        arrays[name] = np.array(mutate_text(str(arrays[name]), rng))
    elif action == 0:
        del arrays[name]
    elif action == 1:
        arrays[name] = arrays[name].astype(rng.choice([np.float32, np.float64, np.int64, bool,
                                                       complex, "U3"]))
    elif action == 2:
        arrays[name] = arrays[name].ravel()[:rng.randrange(1 + arrays[name].size)]
    elif action == 3 and arrays[name].dtype.kind == "f" and arrays[name].size:
        arrays[name].flat[rng.randrange(arrays[name].size)] = rng.choice([np.nan, np.inf, -1.0, 0.0,
                                                                          1e300])
    elif action == 4:
        arrays[name] = np.zeros(rng.choice([(0,), (1, 1), (3, 66, 2), ()]), arrays[name].dtype)
    else:
        arrays[rng.choice(["extra", "W0", "mean"])] = np.zeros(3)
    out = io.BytesIO()
    (np.savez_compressed if rng.random() < 0.1 else np.savez)(out, **arrays)
    return out.getvalue()


class Fuzzer:
    """Makes input number n of each kind and reads it.
    scratch : folder for files;  clips : whole BVH texts to mutate
    """

    def __init__(self, scratch, clips):
        self.scratch, self.clips = Path(scratch), clips
        rng = np.random.default_rng(0)
        params = {"W0": rng.normal(size=(3, FEATURES, 3)).astype(np.float32),
                  "b0": np.zeros(3, np.float32)}
        manifold = Manifold(params, Normaliser(np.zeros(FEATURES), np.ones(FEATURES), "made"), 80.0,
                            np.ones(len(BONES)))
        channels = {"W1": (2, FEATURES, 3), "b1": (2,), "W2": (2, 2, 3), "b2": (2,),
                    "W3": (FEATURES, 2, 3), "b3": (FEATURES,)}
        style = Style({k: np.zeros(s, np.float32) for k, s in channels.items()}, manifold, "old",
                      {"walk": "walk"})
        take = make_take(synthetic.make_clip(seconds=0.3).clip)
        save_manifold(self.scratch / "manifold", manifold)
        save_style(self.scratch / "style", style)
        save_dataset(self.scratch / "motions",
                     assemble([("walk_old_0", take)], {"walk_old_0": ("walk", "old")}, "made"))
        self.archives = [((self.scratch / name).read_bytes(), loader) for name,
                         loader in (("manifold", load_manifold), ("style", load_style),
                                    ("motions", load_dataset))]
        self.clip = synthetic.make_clip(seconds=0.3).clip
        self.labels = "clip,content,style\nwalk_old_0,walk,old\nsub/run_old_1.bvh,run,old\n"
        self.mapping = "slot,joint\nLeftFoot,LeftFoot\n# mine\nHips,Hips\n"

    def run(self, number):
        """Read input `number`.
        ->  "read" or the name of the error that refused it; another exception comes through
        """
        rng = random.Random(number)
        kind = rng.choices(("grammar", "mutation", "npz", "labels", "mapping"),
                           (30, 25, 30, 8, 7))[0]
        path = self.scratch / "input"
        try:
            if kind in ("grammar", "mutation"):
                text = (grammar(rng) if kind == "grammar"
                        else mutate_text(rng.choice(self.clips), rng))
                clip = (bvh.parse_bvh(text) if rng.random() < 0.8
                        else self._from_file(path, text.encode("utf-8", "surrogatepass"), rng))
                again = bvh.parse_bvh(bvh.format_bvh(clip))
                assert again.joints == clip.joints and np.array_equal(again.values, clip.values)
                if kind == "mutation" and rng.random() < 0.1:
                    make_take(clip)
            elif kind == "npz":
                data, loader = rng.choice(self.archives)
                path.write_bytes(mutate_bytes(data, rng) if rng.random() < 0.6
                                 else rewrite_npz(data, rng))
                loader(path)
            elif kind == "labels":
                path.write_bytes(mutate_bytes(self.labels.encode(), rng) if rng.random() < 0.5
                                 else mutate_text(self.labels,
                                                  rng).encode("utf-8", "surrogatepass"))
                labels_from_file([Path("folder/walk_old_0.bvh"), Path("folder/sub/run_old_1.bvh")],
                                 path, Path("folder"))
            else:
                path.write_bytes(mutate_bytes(self.mapping.encode(), rng) if rng.random() < 0.5
                                 else mutate_text(self.mapping,
                                                  rng).encode("utf-8", "surrogatepass"))
                map_clip(self.clip, read_mapping(path))
        except (BVHError, FormatError, LabelError, MappingError) as error:
            assert str(error), "an error must say something"
            return f"{kind}: {type(error).__name__}"
        except ValueError as error:
            # the features' own refusals, as a Take makes them
            if type(error) is ValueError and ": found" in str(error):
                return f"{kind}: ValueError"
            raise
        return f"{kind}: read"

    def _from_file(self, path, data, rng):
        path.write_bytes(mutate_bytes(data, rng) if rng.random() < 0.5 else data)
        return bvh.read_bvh(path)


def campaign(numbers, scratch, clips, seconds=SECONDS):
    """->  Counter of outcomes, list of (number, what went wrong)"""
    fuzzer, outcomes, wrong = Fuzzer(scratch, clips), Counter(), []
    for number in numbers:
        began = time.process_time()
        try:
            with np.errstate(all="ignore"):
                outcomes[fuzzer.run(number)] += 1
        except Exception:
            wrong.append((number, traceback.format_exc()))
        if time.process_time() - began > seconds:
            wrong.append((number, f"took {time.process_time() - began:.1f} s"))
    return outcomes, wrong


def made_clips():
    """Whole texts to mutate, made by the program."""
    return [bvh.format_bvh(synthetic.make_clip(content, "normal", seconds=0.1).clip)
            for content in ("walk", "jog")]


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200_000
    texts = made_clips()
    # real clips, cut after a few frames so that mutations hit the header too
    if len(sys.argv) > 2:
        for path in sorted(Path(sys.argv[2]).rglob("*.bvh"))[::40]:
            lines = path.read_text().splitlines(keepends=True)
            motion = next(i for i, line in enumerate(lines) if line.strip() == "MOTION")
            texts.append("".join(lines[:motion + 1]) + "Frames: 3\n"
                         + "".join(lines[motion + 2:motion + 6]))
    with tempfile.TemporaryDirectory() as folder:
        first = int(sys.argv[3]) if len(sys.argv) > 3 else 0
        outcomes, wrong = campaign(range(first, first + count), folder, texts)
    for outcome, number in sorted(outcomes.items()):
        print(f"{number:8}  {outcome}")
    print(f"{count} inputs, {len(wrong)} that were neither read nor refused as they should be")
    for number, message in wrong[:10]:
        print(f"--- input {number}\n{message}")
    sys.exit(bool(wrong))
