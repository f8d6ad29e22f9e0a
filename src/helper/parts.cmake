# Writes to LIST the libraries that MODULE needs, with dependencies before the libraries that need them. ldd lists
# them from the module downwards, so the list is reversed. Without ldd it is empty, and loading takes longer.
execute_process(COMMAND ldd ${MODULE} OUTPUT_VARIABLE lines ERROR_QUIET RESULT_VARIABLE failed)
string(REGEX MATCHALL "[^ \t\n]+ => /" names "${lines}")
list(REVERSE names)
list(TRANSFORM names REPLACE " => /" "\n")
string(CONCAT text ${names})
file(WRITE ${LIST} "${text}")
