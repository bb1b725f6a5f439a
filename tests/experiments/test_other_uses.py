"""Gestures beside the exemplar's own, with networks too small to be right."""

from refimpl.embedded.walkers import make_database
from refimpl.experiments import other_uses
from refimpl.motion.body import make_take
from refimpl.motion.dataset import assemble


def test_gestures_are_told_beside_the_exemplar_itself():
    motions = make_database(seconds_per_clip=2.0, people=2, contents=("walk", "jog"),
                            styles=("normal", "old", "zombie"))
    dataset = assemble(((m.name, make_take(m.clip)) for m in motions),
                       {m.name: (m.content, m.style) for m in motions}, "test", 0.0)
    rows = list(other_uses.gestures(dataset, "old", "normal", [(0.01, 2), (0.0, 2)], hidden=8,
                                    epochs=1, channels=4))
    assert len(rows) == 3 * 2 and {row["what"] for row in rows[:2]} == {"the exemplar itself"}
    assert rows[0]["style left (content = 1)"] < 1e-6 < rows[2]["style left (content = 1)"]
    learnt = other_uses.varied(dataset.clips[:1])
    assert len(learnt) == 4 and len(learnt[2].features) < 0.82 * len(learnt[0].features)
