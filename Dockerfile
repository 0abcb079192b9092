# README's first command as an ordinary user:
#   docker build -t origami-lab .
#   mkdir -p results && docker run --rm -v "$PWD/results:/work/results" origami-lab target=bowl search=bfts seed=0..9
FROM python:3.12-slim-bookworm

# without it the container's only user is root, and so is what it writes
RUN useradd --create-home --uid 1000 designer \
    && mkdir /work \
    && chown designer:designer /work

WORKDIR /src
COPY pyproject.toml README.md LICENSE constraints.txt ./
COPY conf conf
COPY sweeps sweeps
COPY origami_lab origami_lab
RUN pip install --no-cache-dir . -c constraints.txt

USER 1000
WORKDIR /work
ENV MPLBACKEND=Agg
ENTRYPOINT ["origami-lab"]
CMD ["--help"]
