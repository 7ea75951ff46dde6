# What postproc/draw draws, from results alone: strokes of each colour counted in SVG, frames in GIF, messages.
# cmake -DLIMBER= -DDRAW=<postproc/draw> -DINPUT=<input> -DWORK=<folder> -P drawing.cmake
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
get_filename_component(folder ${LIMBER} DIRECTORY)
set(ENV{PATH} "${folder}:$ENV{PATH}")

# Runs a deck that asks for the motion, and leaves no deck behind
function(run name)
  file(READ ${INPUT}/${name}.inp deck)
  foreach(change ${ARGN})
    string(REPLACE ":" ";" words ${change})
    list(GET words 0 old)
    list(GET words 1 new)
    string(REPLACE ${old} ${new} deck "${deck}")
  endforeach()
  file(WRITE ${WORK}/${name}.inp "${deck}*OUTPUT, MOTION=YES\n")
  execute_process(COMMAND ${LIMBER} run ${WORK}/${name}.inp -o ${WORK}/${name}.h5 --quiet COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE ${WORK}/${name}.inp)
endfunction()

function(draw)
  execute_process(COMMAND ${DRAW} ${ARGN} WORKING_DIRECTORY ${WORK} OUTPUT_VARIABLE path ERROR_VARIABLE complaint
    COMMAND_ERROR_IS_FATAL ANY)
  if(complaint MATCHES "gp. line|plot. line")
    message(FATAL_ERROR "draw ${ARGN}: gnuplot complains:\n${complaint}")
  endif()
endfunction()

# count(<file> <number> <text>): so often the text stands in the file
function(count file number text)
  file(READ ${WORK}/${file} content)
  string(REPLACE "[" "" content "${content}")
  string(REPLACE ";" "" content "${content}")
  string(REGEX MATCHALL "${text}" found "${content}")
  list(LENGTH found length)
  if(NOT length EQUAL number)
    message(FATAL_ERROR "${file} has ${length} times '${text}', not ${number}")
  endif()
endfunction()

# Okabe and Ito's colours, body after body
set(colours "rgb.  0, 114, 178." "rgb.213,  94,   0." "rgb.  0, 158, 115." "rgb.204, 121, 167." "rgb.230, 159,   0."
  "rgb. 86, 180, 233." "rgb.140, 109,  49.")

# Crank, rod and slider with its block: one stroke each, the rod also without its deflection, in grey; pins, mass and block
# are polygons
run(slider_crank_exact "turns = 2:turns = 0.2" OUTPUTS=838:OUTPUTS=40)
draw(slider_crank_exact.h5 --sample 20 --deflection 5 -o crank.svg)
foreach(i RANGE 2)
  list(GET colours ${i} colour)
  count(crank.svg 1 "<path stroke='${colour}'")
endforeach()
count(crank.svg 1 "<path stroke='rgb.128, 128, 128.'")
count(crank.svg 4 "<polygon fill = 'rgb. 32,  32,  32.'")
count(crank.svg 4 "<polygon fill = 'rgb.255, 255, 255.'")
count(crank.svg 1 "<polygon fill = 'rgb.  0, 158, 115.'")
count(crank.svg 1 "<polygon fill = 'rgb.191, 230, 220.'")
count(crank.svg 1 "t = 0.0042 s, deflections × 5")
count(crank.svg 1 "Flexible slider-crank of Han and Lee 1993, large deflections<")
# Without the undeformed rod
draw(slider_crank_exact.h5 --sample 20 --deflection 5 --undeformed no -o bare.svg)
count(bare.svg 0 "<path stroke='rgb.128, 128, 128.'")
count(bare.svg 4 "<polygon fill = 'rgb. 32,  32,  32.'")
# A path more
draw(slider_crank_exact.h5 --path rod.middle --format svg -o path.svg)
count(path.svg 1 "<path stroke='rgb.221, 126,  51.'")
count(path.svg 1 "t = 0.0000 s<")

# Six bars and a triangle, twice; those at the first instant are paler
run(andrews_squeezer END=0.03:END=0.01 OUTPUTS=300:OUTPUTS=30)
draw(andrews_squeezer.h5 --overlay 2 --format svg)
foreach(colour ${colours})
  count(andrews_squeezer.svg 1 "<path stroke='${colour}'")
endforeach()
count(andrews_squeezer.svg 1 "<path stroke='rgb.204, 226, 239.'")
count(andrews_squeezer.svg 1 "<polygon fill = 'rgb.191, 230, 220.'")
# The ground only once, the spring twice, and no points that nobody sees
count(andrews_squeezer.svg 2 "<path stroke='rgb. 64,  64,  64.'")
count(andrews_squeezer.svg 1 "<path stroke='rgb.216, 216, 216.'")
file(SIZE ${WORK}/andrews_squeezer.svg size)
if(size GREATER 40000)
  message(FATAL_ERROR "andrews_squeezer.svg has ${size} bytes")
endif()
count(andrews_squeezer.svg 1 "2 instants, t = 0.0000 s to 0.0100 s")

# A picture, and a film whose frames each begin with 21 f9 04
draw(andrews_squeezer.h5)
file(READ ${WORK}/andrews_squeezer.png head LIMIT 8 HEX)
file(SIZE ${WORK}/andrews_squeezer.png size)
if(NOT head STREQUAL "89504e470d0a1a0a" OR size LESS 20000)
  message(FATAL_ERROR "andrews_squeezer.png is no picture: ${head}, ${size} bytes")
endif()
draw(andrews_squeezer.h5 --format gif --frames 6)
file(READ ${WORK}/andrews_squeezer.gif film HEX)
string(REGEX MATCHALL "0021f904[0-9a-f][0-9a-f]0400" frames "${film}")
list(LENGTH frames number)
if(NOT film MATCHES "^474946383961" OR NOT number EQUAL 6)
  message(FATAL_ERROR "andrews_squeezer.gif is no film of 6 frames, but of ${number}")
endif()

# WebM, or why there is none
find_program(FFMPEG ffmpeg)
execute_process(COMMAND ${DRAW} andrews_squeezer.h5 --format webm --frames 6 WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status
  ERROR_VARIABLE complaint OUTPUT_QUIET)
if(FFMPEG)
  file(READ ${WORK}/andrews_squeezer.webm head LIMIT 4 HEX)
  if(NOT status EQUAL 0 OR NOT head STREQUAL "1a45dfa3")
    message(FATAL_ERROR "andrews_squeezer.webm is no film: ${head}\n${complaint}")
  endif()
elseif(status EQUAL 0 OR NOT complaint MATCHES "WebM needs the program ffmpeg")
  message(FATAL_ERROR "no ffmpeg, and no word of it: ${complaint}")
endif()

# What cannot be drawn
foreach(bad "--sample;31" "--path;k9.end" "--format;bmp" "--frame;6" "--undeformed;maybe")
  execute_process(COMMAND ${DRAW} andrews_squeezer.h5 ${bad} -o bad.png WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status
    ERROR_VARIABLE complaint OUTPUT_QUIET)
  if(status EQUAL 0 OR EXISTS ${WORK}/bad.png OR NOT complaint MATCHES
    "has no sample 31; its samples are 0 to 30|has no point 'k9.end'|there is no format 'bmp'|there is no option --frame|--undeformed is yes or no")
    message(FATAL_ERROR "draw ${bad}: ${complaint}")
  endif()
endforeach()
