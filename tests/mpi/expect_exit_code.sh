#!/bin/sh
# expect_exit_code.sh CODE SECONDS COMMAND…: passes if the command ends within the time with the exit code.
expected=$1 seconds=$2
shift 2
timeout "$seconds" "$@"
code=$?
echo "exit code $code, expected $expected"
test "$code" -eq "$expected"
