#!/usr/bin/env bash
# skipped.sh LOG: prints what unittest skipped inside of the test `python`, and ends with 77 if there is anything.
! grep ' \.\.\. skipped ' "$1" || exit 77
