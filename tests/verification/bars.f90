!> What holds the bar of tests of exact beams, as blocks of a deck: joints on the ground, `far` at the other end.
module bars
   implicit none
   private
   character(*), parameter, public :: nl = new_line('a')
   character(*), parameter, public :: wall = '*JOINT, NAME=wall, TYPE=WELD, TURN=0'//nl//' bar.start, ground.origin'//nl
   character(*), parameter, public :: pin = '*JOINT, NAME=pin, TYPE=REVOLUTE'//nl//' bar.start, ground.origin'//nl
   character(*), parameter, public :: roller = '*JOINT, NAME=roller, TYPE=POINT ON LINE'//nl//' bar.end, ground.far'//nl
   character(*), parameter, public :: guide = '*JOINT, NAME=guide, TYPE=TRANSLATIONAL'//nl//' bar.end, ground.far'//nl
end module bars
