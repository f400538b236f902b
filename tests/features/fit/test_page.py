"""The page "Fit" in a browser: which files it takes."""

QUICK = "?lab=fit&nodes=64&width=160&radius=0.6&u_x_max=12&du_x=0.2&du_z=0.5&E=35"


def test_a_large_file_is_refused_before_it_is_sent_and_an_odd_one_is_named(visit):
    """The connection stays."""
    page = visit(QUICK, rests=False)
    page.get_by_role("button", name="Cancel").wait_for(state="hidden")
    entry = page.locator("input[type=file]")
    entry.set_input_files({"name": "long.csv", "mimeType": "text/csv", "buffer": b"1,2\n" * 1_100_000})
    page.get_by_text("long.csv has 4.4 MB, allowed: 2 MB. Thin it out.").wait_for()
    entry.set_input_files({"name": "odd.csv", "mimeType": "text/csv", "buffer": b"a,b\nc,d\n"})
    page.locator("p[role=alert]", has_text="MB").wait_for(state="hidden")
    page.get_by_text("no points").wait_for()
