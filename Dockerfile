# The program with its workflow; docs/how-to/install.md has the commands
FROM python:3.12-slim-bookworm AS build
# hadolint ignore=DL3008
RUN apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev git && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.12-slim-bookworm
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir "roughcontact[workflow] @ file://$(echo /wheels/*.whl)" && rm -r /wheels
WORKDIR /work
# Snakemake asks for home and name of whoever runs this, who need not be known in here
ENV HOME=/tmp USER=roughcontact
ENTRYPOINT ["roughcontact"]
CMD ["--help"]
