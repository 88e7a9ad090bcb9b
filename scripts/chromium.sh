#!/bin/sh
# Install Chromium through apt for the tests of the view, where there is none. Those tests are skipped without it.
exec sh "$(dirname "$0")/apt.sh" "tests of the view" "chromium|chromium-browser|google-chrome" "chromium"
