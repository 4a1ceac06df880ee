# cmake -DSOURCE=top -DOUT=folder -DMODULE=folder of alabaster -P pack.cmake: makes OUT/alabaster_render.zip
set(staged ${OUT}/alabaster_render)
file(REMOVE_RECURSE ${staged})
file(GLOB sources ${SOURCE}/delegate/blender/alabaster_render/*.py)
file(COPY ${sources} DESTINATION ${staged})
file(COPY ${SOURCE}/schemas/disney_material.json ${SOURCE}/schemas/render_settings.json ${SOURCE}/schemas/quality_presets.json
  DESTINATION ${staged}/schemas)
file(WRITE ${staged}/module_folder.txt "${MODULE}\n")
execute_process(COMMAND ${CMAKE_COMMAND} -E tar cf alabaster_render.zip --format=zip -- alabaster_render
  WORKING_DIRECTORY ${OUT} COMMAND_ERROR_IS_FATAL ANY)
