# Debian 12 with itarl and its Bullet; nothing of what it's built with.
#   docker build --tag itarl .
#   docker run --rm --volume $PWD/runs:/runs itarl train experiments/quick.toml --out /runs/quick
FROM rust:1-slim-bookworm AS build
RUN apt-get update && apt-get install -y --no-install-recommends \
    g++ pkg-config libbullet-dev libclang-dev
WORKDIR /itarl
COPY . .
RUN cargo build --release --locked --bin itarl && strip target/release/itarl && dist/licences.sh /licences

FROM debian:bookworm-slim
RUN apt-get update && apt-get install -y --no-install-recommends libbullet3.24 \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /itarl/target/release/itarl /usr/local/bin/itarl
COPY --from=build /licences /usr/share/doc/itarl/licences
COPY experiments /itarl/experiments
COPY models /itarl/models
WORKDIR /itarl
ENTRYPOINT ["itarl"]
