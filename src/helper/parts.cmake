# Writes to LIST the libraries that MODULE needs, those that others need before these, as far as ldd tells: it goes
# from the module down. Without ldd the list is empty, and loading takes longer.
execute_process(COMMAND ldd ${MODULE} OUTPUT_VARIABLE lines ERROR_QUIET RESULT_VARIABLE failed)
string(REGEX MATCHALL "[^ \t\n]+ => /" names "${lines}")
list(REVERSE names)
list(TRANSFORM names REPLACE " => /" "\n")
string(CONCAT text ${names})
file(WRITE ${LIST} "${text}")
