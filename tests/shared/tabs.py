"""Tabs of the app in a browser, with their errors and requests."""

import re
from urllib.parse import parse_qsl

from served import FINISHED, PATIENCE, finished

DESKTOP = {"width": 1280, "height": 900}
_free = {}  # options -> contexts that no Tabs uses: their caches of scripts make loading a page a third cheaper


class Tabs:
    """Tabs of the app, with the errors they report and the addresses they ask."""

    def __init__(self, server, browser):
        self.server, self.browser = server, browser
        self.used, self.problems, self.asked = [], [], []

    def open(self, query="", **options):
        # a run that plays on takes a core of its own where no graphics card draws: only for who asks, see PLAYING
        options = {"viewport": DESKTOP, "reduced_motion": "reduce"} | options
        free = _free.setdefault(repr(sorted(options.items())), [])
        context = free.pop() if free else self._new_context(options)
        self.used.append((free, context))
        page = context.new_page()
        page.on("console", lambda message: self.problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))
        page.goto(self.server.address + query)
        return page

    def _new_context(self, options):
        context = self.browser.new_context(**options)
        context.set_default_timeout(PATIENCE)
        # as for a visitor who had *More* in sight last; ?more=0 shows the page as it opens
        context.add_init_script("localStorage.getItem('more') ?? localStorage.setItem('more', '1')")
        return context

    def close(self):
        """Close the tabs, and empty their contexts of all that a page can store."""
        for free, context in self.used:
            storage = context.new_cdp_session(context.pages[0])
            kinds = "cookies,local_storage,indexeddb,service_workers"
            storage.send("Storage.clearDataForOrigin", {"origin": self.server.origin, "storageTypes": kinds})
            context.clear_permissions()
            for page in context.pages:
                page.close()
            free.append(context)

    def check(self):
        """Fail if a tab reported an error or made an external request."""
        assert not self.problems, self.problems
        own = re.compile(rf"(http|ws)://localhost:{self.server.port}/|data:|blob:")
        assert not [url for url in self.asked if not own.match(url)]


MODULES = """(names) => {
    window.modules ??= {}
    const key = (name) => name.replace(/[/]index$/, "").split("/").at(-1)
    for (const name of names) {
        const script = document.documentElement.module(name.includes("/") ? `${name}.js` : `static/js/${name}.js`)
        script.then((module) => { modules[key(name)] = module })
    }
    return names.every((name) => key(name) in modules)
}"""
# As a page that was just opened with `search`, at rest after its run: what a test may have changed by the controls of
# the page is changed back, then the scene is restored as that of a link.
AS_OPENED = """([search, wanted]) => {
    const { history: address, pages, player: { play } } = window.modules
    const all = (what) => [...document.querySelectorAll(what)], by = (id) => document.getElementById(id)
    const { dataset } = document.documentElement
    const change = (input, value) => {
        Object.assign(input, value)
        input.dispatchEvent(new Event("change", { bubbles: true }))
    }
    play(false)
    by("find").value = ""
    all("dialog[open]").forEach((dialog) => dialog.close())
    all(":popover-open").forEach((popover) => popover.hidePopover())
    const tour = all("#tour-card:not([hidden]) button")
    tour.find(({ textContent }) => textContent === "End tour")?.click()
    all(".chip [aria-label^=Remove]").forEach((remove) => remove.click())
    if (document.querySelector(".sheet:not([hidden])")) pages.openPage("")
    for (const box of all(".page input[type=checkbox], input[name=chosen], input[name=one]"))
        if (box.checked !== box.defaultChecked && (box.type !== "radio" || box.defaultChecked))
            change(box, { checked: box.defaultChecked })
    const usual = by("speed").querySelector("[selected]").value
    if (by("speed").value !== usual) change(by("speed"), { value: usual })
    if (dataset.theme !== wanted.theme) by("theme").click()
    if ((dataset.view === "projector") !== (wanted.view === "projector")) by("projector").click()
    if ((by("more").ariaPressed === "true") !== (wanted.more === "1")) by("more").click()
    by("lens").dispatchEvent(new MouseEvent("dblclick")) // back to where it is by itself
    document.activeElement.blur()
    Object.assign(punch, { following: true, preview: null, place: null, speed: Number(usual), rests: 400 })
    const scene = address.sceneOf(search), known = { ...scene, view: 1, more: 1, theme: 1, page: 1, k: 1 }
    for (const [name] of new URLSearchParams(search))
        if (!(name in known)) throw new Error(`${name} needs a tab of its own`)
    const text = (one) => JSON.stringify(Object.entries(one).toSorted())
    const k = new URLSearchParams(search).get("k")
    if (text(scene) !== text(punch.status.address) || k !== null || Object.keys(punch.status.errors ?? {}).length)
        address.goBackTo(scene, k && Number(k))
}"""
AS_FRESH = """() => {
    if (punch.following) window.modules.player.goto(Infinity)
    Object.assign(punch, { ghost: null, start: null, following: true, look: punch.look + 1 })
    window.before = punch.status.run - 1
}"""


def imported(page, *names):
    """The page, with scripts of static/js, or of a feature by its path, as `modules.NAME`; an index by its folder.

    A busy browser may drop a pending import() of evaluated code ("promise was garbage collected"): it is repeated
    until the script is there.
    """
    page.wait_for_function(MODULES, arg=names)
    return page


def at_stop(page, stop):
    """The page at a stop of the tour, as `?tour=` opens it, once it asks."""
    imported(page, "features/tour/tour").evaluate(f"modules.tour.openTour({stop})")
    asked(page)
    return page


def asked(page):
    """When a stop of the tour asks."""
    page.locator("#tour-card button.answer").first.wait_for()


class SharedTab:
    """One tab for many tests, as loading the page costs more than most of them: `show` brings it to any address."""

    def __init__(self, server, browser):
        self.tabs, self.page = Tabs(server, browser), None

    def show(self, query=""):
        """The page at rest after its run, as if it had been opened with this address."""
        try:
            if self.page is None:
                self.page = self.tabs.open()
                finished(self.page)
                imported(self.page, "features/history/index", "features/pages/index", "player")
            return self._brought_to(query)
        except Exception:
            self.close()  # whatever state it is in
            raise

    def _brought_to(self, query):
        page, asked = self.page, dict(parse_qsl(query.removeprefix("?"), keep_blank_values=True))
        page.set_viewport_size(DESKTOP)
        page.mouse.move(1, 1)
        page.evaluate(AS_OPENED, [query, {"theme": "light", "more": "1"} | asked])
        page.wait_for_function(
            "!punch.waiting.length && !punch.stale && !document.querySelector('.sheet:not([hidden])')"
        )
        page.wait_for_function(FINISHED)
        page.evaluate(AS_FRESH)
        page.wait_for_function("() => !punch.fresh && punch.mapped && !punch.playing")
        if "page" in asked:
            page.locator(f"nav button[data-page={asked['page']}]").evaluate("(button) => button.click()")
            page.wait_for_function(f"!{asked['page']}.hidden && !('drawing' in {asked['page']}.dataset)")
        return page

    def check(self):
        """Fail if the test since the last check caused an error or an external request."""
        try:
            self.tabs.check()
        finally:
            self.tabs.problems, self.tabs.asked = [], []  # the old ones are what the failure reports

    def close(self):
        if self.page:
            self.tabs.close()
        self.page, self.tabs = None, Tabs(self.tabs.server, self.tabs.browser)
