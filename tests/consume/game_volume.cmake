# SPDX-License-Identifier: Apache-2.0
# Bakes a coarse pool and writes it as a game loads it.
execute_process(COMMAND ${PROGRAM} bake ${SCENE} --voxel-size 0.03125 -o ${OUTPUT}.vdb --progress none COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PROGRAM} export ${OUTPUT}.vdb -o ${OUTPUT}.nvdb --progress none COMMAND_ERROR_IS_FATAL ANY)
