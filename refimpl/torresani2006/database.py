r"""A database: fragments of one skeleton with contents and styles, and how to train f on their
blends.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..motion.bvh import read_bvh
from ..motion.dataset import PATTERN, find_clips, labels_by_pattern
from ..embedded import performers
from .align import HIGHEST, LOWEST, all_pairs, clusters, interpolate, threshold_for
from .observe import Observer, fit_observer, observe, read_labels
from .poses import FPS, Body, fit_body, fragment_of
from .regress import COMPONENTS, Projection, fit_model, fit_pca, inputs, project

BLENDS = 400


class DatabaseError(ValueError):
    """A database without what is needed of it."""


@dataclass(frozen=True)
class Database:
    """fragments : tuple of Fragment with content and style;  ssd : (N, N);  observer : the computed
    one;  labelled : by an analyst.
    """

    fragments: tuple
    body: Body
    ssd: np.ndarray = field(repr=False)
    observer: Observer = field(repr=False)
    labelled: bool = False

    @property
    def styles(self):
        return np.array([fragment.style for fragment in self.fragments])


@dataclass(frozen=True)
class Blends:
    """Space-time interpolations with their styles.
    pairs : (M, 2) fragment numbers;  alpha : (M,);  styles : (M, 3).
    """

    pairs: np.ndarray
    alpha: np.ndarray
    styles: np.ndarray


def make_database(fragments, body, *, contents=None, relative=True):
    """Complete some fragments: contents by clustering where none are known, styles by the computed
    observer where none are given.

    fragments : list of Fragment;  contents : how many contents to look for among fragments without
    one, by default one for every 12
    ->  Database.
    Raises DatabaseError for fewer than two fragments, ObserveError when no content has two.
    """
    fragments = list(fragments)
    if len(fragments) < 2:
        raise DatabaseError(
            f"fragments: found {len(fragments)}, needed at least 2 to interpolate between")
    ssd = all_pairs([fragment.angles for fragment in fragments])
    if any(fragment.content is None for fragment in fragments):
        count = contents or max(1, round(len(fragments) / 12))
        found = clusters(ssd, threshold_for(ssd, count))
        fragments = [
            replace(fragment, content=f"content {c + 1}") for fragment, c in zip(fragments, found)]
    observer = fit_observer(fragments, body, relative)
    labelled = all(fragment.style is not None for fragment in fragments)
    fragments = tuple(
        replace(f, style=observe(f, observer) if f.style is
                None else np.asarray(f.style, dtype=float)) for f in fragments)
    return Database(fragments, body, ssd, observer, labelled)


def embedded_database(number=12, first=0, relative=True):
    """The embedded performers: five actions each.   ->  Database"""
    made = performers.make_performers(number, first=first)
    body = fit_body([performance.clip for performance in made])
    return make_database([fragment_of(p.clip, body, p.name, p.contents[0]) for p in made], body,
                         relative=relative)


def read_database(folder, *, labels=None, pattern=PATTERN, contents=None, fps=FPS, keep=None,
                  report=None):
    """A folder of BVH clips as a database.

    labels : an analyst's label file, whose every line is a fragment; without it every clip is one,
    observed by the computed observer;
    pattern : content from file names, see `motion.dataset.labels_by_pattern`; a database in which
    some clip does not fit it is clustered;
    contents : how many, see `make_database`;  keep : function (content, style name) ->  bool, which
    clips to read;
    report : called with each path   ->  Database
    Raises the errors of reading, LabelError, PoseError, DatabaseError.
    """
    paths = find_clips(folder)
    named = labels_by_pattern(paths, pattern)
    paths = [path for path in paths if keep is None or path in named and keep(*named[path])]
    clips = {}
    for path in paths:
        clips[path] = read_bvh(path)
        if report:
            report(path)
    if not clips:
        raise DatabaseError(
            f"{folder}: found no clip of the contents and styles asked for; are they in the file "
            "names?")
    body = fit_body(clips.values())
    content = {path: named[path][0] if len(named) >= len(paths) else None for path in paths}
    if labels is None:
        return make_database([
            fragment_of(clip, body, path.stem, content[path], fps=fps)
            for path, clip in clips.items()], body, contents=contents)
    by_name = {path.stem: path for path in paths}
    lines = read_labels(labels, {path.stem: clip.frames for path, clip in clips.items()})
    parts = [
        fragment_of(
            clips[by_name[line.clip]], body, f"{line.clip}[{line.start}:{line.end}]",
            content[by_name[line.clip]] if
            (line.start, line.end) == (0, clips[by_name[line.clip]].frames) else None, line.style,
            start=line.start, end=line.end, fps=fps) for line in lines]
    if any(part.content is None for part in parts):
        parts = [replace(part, content=None) for part in parts]
    return make_database(parts, body, contents=contents)


def without(database, keep):
    """The database of some fragments only, with the styles they have.
    keep : (N,) bool  ->  Database
    """
    chosen = np.flatnonzero(keep)
    return replace(database, fragments=tuple(database.fragments[n] for n in chosen),
                   ssd=database.ssd[np.ix_(chosen, chosen)])


def random_blends(database, count, rng, report=None):
    """Blends of random pairs of one content at random alphas in [-0.25, 1.25], observed by the
    computed observer.   ->  Blends
    """
    contents = np.array([fragment.content for fragment in database.fragments])
    i, j = np.nonzero((contents[:, None] == contents) & ~np.eye(len(contents), dtype=bool))
    if not len(i):
        raise DatabaseError(
            "database: found no two fragments of one content, needed some to interpolate between")
    chosen = rng.choice(len(i), count, replace=count > len(i))
    alpha = rng.uniform(LOWEST, HIGHEST, count)
    styles = []
    for n, a in zip(chosen, alpha):
        styles.append(
            observe(
                interpolate(database.fragments[i[n]], database.fragments[j[n]], a,
                            up=database.body.up), database.observer))
        if report:
            report(len(styles))
    return Blends(np.stack([i[chosen], j[chosen]], axis=1), alpha, np.array(styles))


def coefficients(database, projection):
    """c of every fragment.   ->  (N, components)"""
    return np.array([project(projection, fragment.angles) for fragment in database.fragments])


def blend_inputs(c, e, pairs, alpha):
    """z of equation 1 for pairs of fragments.
    c : (N, components), e : (N, 3), pairs : (M, 2), alpha : (M,)  ->  (M, 2 components + 7)
    """
    return inputs(c[pairs[:, 0]], c[pairs[:, 1]], e[pairs[:, 0]], e[pairs[:, 1]], alpha)


def train(database, kind="kernel ridge", *, blends=BLENDS, components=COMPONENTS, seed=0,
          report=None):
    """Fit f on blends of the database and on its fragments, which are blends with alpha 0 or 1.
    ->  StyleModel, Projection

    blends : how many, 400 unless given (Table 1 has the paper's 105). An analyst's labels cover the
    fragments alone; the paper's expert labelled the blends too, for which there is no way in yet.
    Here the blends take the labels' interpolation plus what the computed observer sees beside its
    own interpolation (a choice).
    """
    rng = np.random.default_rng([seed, 3])
    made = random_blends(database, blends, rng, report)
    projection = fit_pca([fragment.angles for fragment in database.fragments],
                         min(components,
                             len(database.fragments) - 1))
    styles = made.styles
    if database.labelled:
        computed = np.array([
            observe(fragment, database.observer) for fragment in database.fragments])
        i, j, a = *made.pairs.T, made.alpha[:, None]
        between = [(1 - a) * e[i] + a * e[j] for e in (database.styles, computed)]
        styles = np.clip(between[0] + styles - between[1], -3, 3)
    of_content = _first_partners(database)
    pairs = np.concatenate([made.pairs, of_content, of_content[:, ::-1]])
    alpha = np.concatenate([made.alpha, np.zeros(len(of_content)), np.ones(len(of_content))])
    styles = np.concatenate([
        styles, database.styles[of_content[:, 0]], database.styles[of_content[:, 0]]])
    Z = blend_inputs(coefficients(database, projection), database.styles, pairs, alpha)
    return fit_model(kind, Z, styles, rng), projection


def _first_partners(database):
    """Every fragment with the nearest one of its content, where it has any.   ->  (M, 2)"""
    contents = np.array([fragment.content for fragment in database.fragments])
    other = (contents[:, None] != contents) | np.eye(len(contents), dtype=bool)
    nearest = np.where(other, np.inf, database.ssd).argmin(axis=1)
    return np.stack([np.arange(len(contents)), nearest], axis=1)[~other.all(axis=1)]
