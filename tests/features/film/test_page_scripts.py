"""The frames of a slow motion."""

from scripts import SHORT, run_of


def test_a_film_begins_with_the_frames_of_its_run(tab):
    run_of(tab, SHORT)
    counts = tab.evaluate(
        """(async () => {
            const { Run } = await import("http://scripts/static/js/run.js"), next = new Run(8, run.head)
            const { takeOver } = await import("http://scripts/features/film/film.js")
            takeOver(next, run, run.sheared + 5)
            return [next.length, run.sheared + 6, next.curves.U_x.at(-1), run.curves.U_x[run.sheared + 5]]
        })()"""
    )
    assert counts[0] == counts[1] and counts[2] == counts[3]
