FROM python:3.11-slim

# The cache holds compiled kernels: filled while the image is built, and copied where it can be written to when it is
# run, so that a machine with another processor can compile its own; all else may be read-only.
ENV PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    PIP_NO_CACHE_DIR=1 \
    PIP_DISABLE_PIP_VERSION_CHECK=1 \
    NUMBA_CACHE_DIR=/srv/numba

RUN useradd --create-home --uid 1000 contact && install -d -o contact -g contact /srv/numba
WORKDIR /srv/contact

# Dependencies first: a change of the code leaves their layer as it is. Each wheel must have a listed hash.
COPY image.txt ./
RUN pip install --require-hashes --only-binary :all: -r image.txt
COPY pyproject.toml ./
COPY README.md LICENSE ./
COPY solver solver
COPY app app
# Editable: the server and the kernels compiled below must see the same source files, or the cache would not match.
RUN pip install --no-deps --no-build-isolation -e .

USER contact
# Before each run the command compiles every kernel of its method, a worker those of the pages too; workers find them in
# the cache.
RUN python -c "from app.service import worker; worker.start()" && for method in fast gfmd; do \
        python -m solver run --method "$method" --set nodes=64 width=160 u_x_max=1 || exit 1; \
    done

# The host:port that visitors type into their browser; several are separated by commas.
ENV BOKEH_ALLOW_WS_ORIGIN=localhost:5006
EXPOSE 5006
HEALTHCHECK --interval=30s --timeout=10s --start-period=90s \
    CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:5006/liveness', timeout=8)"]
ENV NUMBA_CACHE_DIR=/tmp/numba
CMD ["sh", "-c", "cp -r /srv/numba /tmp/ && exec panel serve app --address 0.0.0.0 --port 5006"]
