#!/usr/bin/env bash
# Tornado: after HTTPServer.start(2) the parent waits for its children. SIGTERM ends the parent alone: its children go on
# and answer at the port, so that whoever stops a service by the process he started leaves servers behind.
set -euo pipefail
folder=$(mktemp -d)
trap 'kill $(cat "$folder"/pid.* 2>/dev/null) 2>/dev/null || true; rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet tornado==6.6.1
cat > "$folder/serve.py" <<'PY'
import os, sys
from pathlib import Path
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.web import Application, RequestHandler

class Answer(RequestHandler):
    def get(self):
        self.write("answered")

folder = Path(sys.argv[1])
sockets = bind_sockets(0, "127.0.0.1")
(folder / "port").write_text(str(sockets[0].getsockname()[1]))
server = HTTPServer(Application([("/", Answer)]))
server.start(2)
server.add_sockets(sockets)
IOLoop.current().add_callback((folder / f"pid.{os.getpid()}").write_text, f"{os.getpid()}\n")
IOLoop.current().start()
PY
"$folder/venv/bin/python" -c 'import tornado; print("tornado", tornado.version)'
"$folder/venv/bin/python" "$folder/serve.py" "$folder" 2>/dev/null &
parent=$!
until [[ $(find "$folder" -name 'pid.*' -size +0 | wc -l) -eq 2 ]]; do kill -0 "$parent"; sleep 0.1; done
kill -TERM "$parent"
wait "$parent" || echo "the parent ended by signal, exit status $?"
answer=$("$folder/venv/bin/python" -c '
import sys, urllib.request
opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
print(opener.open(f"http://127.0.0.1:{open(sys.argv[1]).read()}/", timeout=20).read().decode())' "$folder/port") || answer=none
echo "after that, at the same port: $answer"
[[ $answer == answered ]] && kill -0 $(cat "$folder"/pid.*)
echo "as found: both children go on without their parent"
