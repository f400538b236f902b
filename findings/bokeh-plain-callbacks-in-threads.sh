#!/usr/bin/env bash
# Bokeh 3.10 calls a plain next-tick callback in a thread of its own, and 3.9 on the loop of the server: the same program,
# without a word, shares its data between threads. A coroutine function stays on the loop in both.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for python in "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.13*/bin/python python3.13; do
    if "$python" -c '' 2>/dev/null; then break; fi
done
cat > "$folder/threads.py" <<'PY'
import asyncio
import threading

import bokeh
from bokeh.document import Document
from bokeh.server.session import ServerSession
from tornado.ioloop import IOLoop

async def main():
    session, seen = ServerSession("one", Document(), io_loop=IOLoop.current()), {}

    def plain():
        seen["plain"] = threading.get_ident() == loop

    async def coroutine():
        seen["coroutine"] = threading.get_ident() == loop

    loop = threading.get_ident()
    session.document.add_next_tick_callback(plain)
    session.document.add_next_tick_callback(coroutine)
    while len(seen) < 2:
        await asyncio.sleep(0.01)
    print("bokeh", bokeh.__version__, "on the loop's thread:", sorted(seen.items()))
    assert seen == {"plain": bokeh.__version__ == "3.9.2", "coroutine": True}

asyncio.run(main())
PY
for version in 3.9.2 3.10.2; do
    "$python" -m venv "$folder/$version"
    "$folder/$version/bin/pip" install --quiet bokeh==$version tornado==6.6.1
    "$folder/$version/bin/python" "$folder/threads.py"
done
echo "as found: 3.10.2 calls a plain callback in another thread"
