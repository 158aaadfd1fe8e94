# Writes OUTPUT from INPUT with the commit of the moment. Run by every build: a commit that was stamped when the build
# tree was configured would go on naming an older one. Leaves the file alone when nothing changed.
#   cmake -DSOURCE=... -DGIT=... -DINPUT=... -DOUTPUT=... -DVERSION=... -DCOMPILER=... -DFLAGS=... -DBUILD_TYPE=... -P this
set(COMMIT "")
if(GIT)
  execute_process(
    COMMAND ${GIT} describe --always --dirty=+ --abbrev=12 --exclude=*
    WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
