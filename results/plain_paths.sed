# Of absolute paths in a command only the file's name says anything on another machine.
s#(["' ])/[^"' ]*/#\1#g
s#file:/[^"' ]*/#file:#g
