# The image of all services of ours in docker-compose.yml: the server, and simulated shuttles.

FROM node:22-slim AS pages
WORKDIR /src/web
COPY web/package.json web/package-lock.json ./
RUN npm ci --no-audit --no-fund --loglevel=error
COPY web ./
RUN npm run --silent build

FROM python:3.11-slim AS environment
WORKDIR /opt/campusloop
# The caches are valid on every processor of this architecture, and results are the same on all of them.
ENV NUMBA_CPU_NAME=generic NUMBA_CPU_FEATURES=""
COPY requirements/run.txt requirements/run.txt
RUN python -m venv .venv && .venv/bin/pip install --no-cache-dir --no-deps --require-hashes -r requirements/run.txt
COPY pyproject.toml README.md LICENSE ./
COPY sdk sdk
COPY maps maps
COPY migrations migrations
COPY contract contract
COPY server server
COPY vehicle_agent vehicle_agent
COPY simulator simulator
COPY workshop workshop
COPY campusloop campusloop
RUN .venv/bin/pip install --no-cache-dir --no-build-isolation --no-deps -e . -e sdk/python && .venv/bin/campusloop warm

FROM python:3.11-slim
ENV PATH=/opt/campusloop/.venv/bin:$PATH NUMBA_CPU_NAME=generic NUMBA_CPU_FEATURES="" PYTHONUNBUFFERED=1 \
    CAMPUSLOOP_VAR_DIR=/var/lib/campusloop CAMPUSLOOP_WEB_DIST=/opt/campusloop/web/dist
RUN useradd --system --uid 10001 campusloop && install -d -o campusloop /var/lib/campusloop /segments
COPY --from=environment /opt/campusloop /opt/campusloop
COPY --from=pages /src/web/dist /opt/campusloop/web/dist
USER 10001
WORKDIR /opt/campusloop
VOLUME /var/lib/campusloop
EXPOSE 8080
ENTRYPOINT ["campusloop"]
CMD ["serve", "--host", "0.0.0.0", "--tls-self-signed"]
