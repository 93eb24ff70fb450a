#!/bin/bash
# Puts the results of a sweep together. Runs behind its arrays however they ended; ends with code 3 if points are missing.
@SETUP@
exec @PROGRAM@ sweep merge @SWEEP@ --patience @PATIENCE@
