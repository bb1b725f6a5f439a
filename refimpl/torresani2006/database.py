"""A database: fragments of one skeleton with contents and styles, and how to train f on their
blends.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..motion.bvh import read_bvh
from ..motion.dataset import PATTERN, find_clips, labels_by_pattern
from ..embedded import performers
from .align import HIGHEST, LOWEST, all_pairs, clusters, threshold_for
from .blend import smooth
from .content import Contents, contents_of_names, groups
from .efforts import BY_SWINGS
from .labels import joint, overlaps, read_labels
from .observe import Observer, Sight, fit_observer, observe
from .pca import COMPONENTS, PrincipalComponents, fit_pca, pca_scores
from .poses import POSE_FPS, Body, Fragment, fit_body, fragment_of
from .regress import StyleModel, fit_model, inputs

BLENDS = 400


class DatabaseError(ValueError):
    """A database without what is needed of it."""


@dataclass(frozen=True)
class Database:
    """Fragments that all have a content and a style.

    ssd : (N, N) of `align.all_pairs`;  observer : the computed one;  labelled : by an analyst;
    performers : who did each, where that is known;  warning : of its contents;
    between : of (fragment, fragment, alpha, body), their blend.
    """

    fragments: tuple[Fragment, ...]
    body: Body
    ssd: np.ndarray = field(repr=False)
    observer: Observer = field(repr=False)
    labelled: bool = False
    performers: tuple[str, ...] | None = None
    warning: str = ""
    between: Callable[[Fragment, Fragment, float, Body], Fragment] = smooth

    def blend(self, i: int, j: int, alpha: float) -> Fragment:
        """Two of the fragments, blended."""
        return self.between(self.fragments[i], self.fragments[j], alpha, self.body)

    def contents(self) -> Contents:
        """What contents are told by where performers are known (`content`)."""
        return contents_of_names([f.angles for f in self.fragments],
                                 [str(f.content) for f in self.fragments], self.performers or ())

    @property
    def styles(self) -> np.ndarray:
        """(N, 3) flow, weight, time."""
        return np.array([fragment.style for fragment in self.fragments])


@dataclass(frozen=True)
class Blends:
    """Space-time interpolations with their styles.

    pairs : (M, 2) fragment numbers;  alpha : (M,);  styles : (M, 3).
    """

    pairs: np.ndarray
    alpha: np.ndarray
    styles: np.ndarray


def database_of(fragments: Sequence[Fragment], body: Body, *, contents: int | None = None,
                sight: Sight = BY_SWINGS, styles: bool = True) -> Database:
    """Complete some fragments: contents by clustering (section 4) where none are known, styles by
    the computed observer where none are given.

    contents : how many to look for among fragments without one, by default one for every 12;
    sight : what the observer looks at;  styles : whether anybody wants them, which takes two
    fragments of one content; segmentation does not.
    Raises DatabaseError for fewer than two fragments, ObserveError when no content has two.
    """
    fragments = list(fragments)
    if len(fragments) < 1 + styles:
        raise DatabaseError(f"fragments: found {len(fragments)}, needed at least 2 to interpolate "
                            "between")
    unknown = any(f.content is None for f in fragments)
    ssd = (all_pairs([f.angles for f in fragments]) if styles or unknown else
           np.full((len(fragments),) * 2, np.nan))
    if unknown:
        count = contents or max(1, round(len(fragments) / 12))
        found = clusters(ssd, threshold_for(ssd, count))
        fragments = [replace(f, content=f"content {c + 1}") for f, c in zip(fragments, found)]
    observer = (fit_observer(fragments, body, sight) if styles else
                Observer({None: sight.usual}, np.zeros(3), body, sight))
    labelled = all(f.style is not None for f in fragments)
    complete = tuple(replace(f, style=np.zeros(3) if not styles else observe(f, observer)
                             if f.style is None else np.asarray(f.style, dtype=float))
                     for f in fragments)
    return Database(complete, body, ssd, observer, labelled)


def embedded_database(number: int = 12, first: int = 0, sight: Sight = BY_SWINGS) -> Database:
    """The embedded performers, five actions each.

    >>> embedded_database(2).styles.shape
    (10, 3)
    """
    made = performers.make_performers(number, first=first)
    body = fit_body([performance.clip for performance in made])
    found = database_of([fragment_of(p.clip, body, p.name, p.contents[0]) for p in made], body,
                        sight=sight)
    return replace(found, performers=tuple(p.name.rsplit("_", 1)[1] for p in made))


def read_database(folder: str | Path, *, labels: str | Path | None = None,
                  pattern: str = PATTERN, contents: int | None = None, fps: float = POSE_FPS,
                  keep: Callable[[str, str], bool] | None = None, styles: bool = True,
                  report: Callable[[Path], None] = lambda path: None) -> Database:
    """A folder of BVH clips as a database.

    labels : an analyst's label file, whose every line is a fragment; without it every clip is one,
    observed by the computed observer;
    pattern : content from file names, see `motion.dataset.labels_by_pattern`; a database in which
    some clip does not fit it is grouped by complete linkage of SSD a frame (`content.groups`);
    contents, styles : see `database_of`;  keep : of (content, style name), which clips to read;
    report : called with each path.
    Raises the errors of reading, LabelError, PoseError, DatabaseError.
    """
    paths = find_clips(folder)
    named = labels_by_pattern(paths, pattern)
    paths = [path for path in paths if keep is None or path in named and keep(*named[path])]
    clips = {}
    for path in paths:
        clips[path] = read_bvh(path)
        report(path)
    if not clips:
        raise DatabaseError(f"{folder}: found no clip of the contents and styles asked for; are "
                            "they in the file names?")
    body = fit_body(clips.values())
    content = {path: named[path][0] if len(named) >= len(paths) else None for path in paths}
    by_name = {path.stem: path for path in paths}
    twice = {path.stem: path for path in paths if by_name[path.stem] != path}
    if labels is None:
        told = "; ".join(f"{path} and {by_name[name]} have one name; both are fragments"
                         for name, path in twice.items())
        found = _grouped([fragment_of(clip, body, path.stem, content[path], fps=fps)
                          for path, clip in clips.items()], body, contents, styles, told)
        return replace(found, performers=tuple(named[path][1] for path in clips)
                       if len(named) >= len(paths) else None)
    parts, frames = [], {path.stem: clip.frames for path, clip in clips.items()}
    lines = joint(read_labels(labels, frames))
    for line in lines:
        if line.clip in twice:
            raise DatabaseError(
                f"{labels}:{line.line}: found {line.clip!r} twice, as {twice[line.clip]} and "
                f"{by_name[line.clip]}, needed one clip of a name; rename one of them")
        path, stretch = by_name[line.clip], (line.start, line.end)
        known = content[path] if stretch == (0, clips[path].frames) else None
        name = f"{line.clip}[{line.start}:{line.end}]"
        parts.append(fragment_of(clips[path], body, name, known, line.style, start=line.start,
                                 end=line.end, fps=fps))
    if any(part.content is None for part in parts):
        parts = [replace(part, content=None) for part in parts]
    return _grouped(parts, body, contents, styles, overlaps(lines))


def _grouped(fragments, body, contents, styles, told):
    """`database_of` with contents by complete linkage of SSD a frame where they are not known, and
    what is to be warned of, `told` among it."""
    warning = ""
    if any(f.content is None for f in fragments) and len(fragments) > 1:
        lengths = np.array([f.frames for f in fragments])
        far = all_pairs([f.angles for f in fragments]) / (lengths[:, None] + lengths)
        found, warning = groups(far, contents or max(1, round(len(fragments) / 12)))
        fragments = [replace(f, content=f"content {n + 1}") for f, n in zip(fragments, found)]
    return replace(database_of(fragments, body, styles=styles),
                   warning="; ".join(x for x in (told, warning) if x))


def without(database: Database, keep: np.ndarray) -> Database:
    """The database of some fragments only, keep : (N,) bool, with the styles that they have.

    >>> without(embedded_database(2), np.arange(10) < 5).ssd.shape
    (5, 5)
    """
    chosen = np.flatnonzero(keep)
    who = database.performers
    return replace(database, fragments=tuple(database.fragments[n] for n in chosen),
                   ssd=database.ssd[np.ix_(chosen, chosen)],
                   performers=who and tuple(who[n] for n in chosen))


def random_blends(database: Database, count: int, rng: np.random.Generator,
                  report: Callable[[int], None] = lambda done: None) -> Blends:
    """Blends of random pairs of one content at random alphas in [-0.25, 1.25], observed by the
    computed observer.   report : called with the number of blends done.
    """
    return blends_of(database, random_pairs(database, count, rng),
                     rng.uniform(LOWEST, HIGHEST, count), report)


def random_pairs(database: Database, count: int, rng: np.random.Generator) -> np.ndarray:
    """Pairs of fragments of one content, each pair once as far as they go, in a random order of the
    two.   ->  (count, 2).   Raises DatabaseError where there is none.
    """
    i, j = np.nonzero(np.triu(_same_content(database)))
    if not len(i):
        raise DatabaseError(
            "database: found no two fragments of one content, needed some to interpolate between")
    chosen = rng.choice(len(i), count, replace=count > len(i))
    pairs = np.stack([i[chosen], j[chosen]], axis=1)
    return np.where(rng.random(count)[:, None] < 0.5, pairs, pairs[:, ::-1])


def blends_of(database: Database, pairs: np.ndarray, alpha: np.ndarray,
              report: Callable[[int], None] = lambda done: None) -> Blends:
    """Blends of these pairs at these alphas, observed by the computed observer.

    pairs : (M, 2) fragment numbers, alpha : (M,);  report : called with the number of blends done
    """
    styles: list[np.ndarray] = []
    for (first, second), a in zip(pairs, alpha):
        styles.append(observe(database.blend(first, second, a), database.observer))
        report(len(styles))
    return Blends(pairs, alpha, np.array(styles))


def coefficients(database: Database, pca: PrincipalComponents) -> np.ndarray:
    """c of every fragment.   ->  (N, components)"""
    return np.array([pca_scores(pca, fragment.angles) for fragment in database.fragments])


def blend_inputs(c: np.ndarray, e: np.ndarray, pairs: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """z for pairs of fragments.
    c : (N, components), e : (N, 3), pairs : (M, 2), alpha : (M,)  ->  (M, 2 components + 7)

    >>> c, e = np.array([[1.0], [2.0]]), np.array([[3.0, 3.0, 3.0], [4.0, 4.0, 4.0]])
    >>> blend_inputs(c, e, np.array([[1, 0]]), np.array([0.5]))
    array([[2. , 1. , 4. , 4. , 4. , 3. , 3. , 3. , 0.5]])
    """
    return inputs(c[pairs[:, 0]], c[pairs[:, 1]], e[pairs[:, 0]], e[pairs[:, 1]], alpha)


def train(database: Database, kind: str = "kernel ridge", *, blends: int = BLENDS,
          components: int = COMPONENTS, seed: int = 0,
          report: Callable[[int], None] = lambda done: None
          ) -> tuple[StyleModel, PrincipalComponents]:
    """Fit f on blends of the database and on its fragments, which are blends with alpha 0 or 1.

    blends : how many, 400 unless given (Table 1 has the paper's 105). An analyst's labels cover the
    fragments alone; the paper's expert labelled the blends too, for which there is no way in yet.
    Here the blends take the labels' interpolation plus what the computed observer sees beside its
    own interpolation (a choice).
    """
    rng = np.random.default_rng([seed, 3])
    return train_on(random_blends(database, blends, rng, report), database, kind, components, rng)


def train_on(made: Blends, database: Database, kind: str, components: int,
             rng: np.random.Generator) -> tuple[StyleModel, PrincipalComponents]:
    """The same on blends that are made already.   rng : deals the folds of cross-validation"""
    pca = fit_pca([fragment.angles for fragment in database.fragments],
                  min(components, len(database.fragments) - 1))
    styles = made.styles
    if database.labelled:
        computed = np.array([observe(f, database.observer) for f in database.fragments])
        (i, j), a = made.pairs.T, made.alpha[:, None]
        between = [(1 - a) * e[i] + a * e[j] for e in (database.styles, computed)]
        styles = np.clip(between[0] + styles - between[1], -3, 3)
    of_content = _first_partners(database)
    pairs = np.concatenate([made.pairs, of_content, of_content[:, ::-1]])
    alpha = np.concatenate([made.alpha, np.zeros(len(of_content)), np.ones(len(of_content))])
    own = database.styles[of_content[:, 0]]
    Z = blend_inputs(coefficients(database, pca), database.styles, pairs, alpha)
    return fit_model(kind, Z, np.concatenate([styles, own, own]), rng), pca


def _same_content(database):
    """Which pairs of two fragments are of one content.   ->  (N, N) bool"""
    contents = np.array([fragment.content for fragment in database.fragments])
    return (contents[:, None] == contents) & ~np.eye(len(contents), dtype=bool)


def _first_partners(database):
    """Every fragment with the nearest one of its content, where it has any.   ->  (M, 2)"""
    same = _same_content(database)
    nearest = np.where(same, database.ssd, np.inf).argmin(axis=1)
    return np.stack([np.arange(len(same)), nearest], axis=1)[same.any(axis=1)]
