!> Beams in segments: all that a deck says of a beam means the same of one in pieces; with more pieces large deflections approach
!> those of geometrically exact beams, as Exudyn 1.9 finds them with 64 and 128 elements of the absolute nodal coordinate
!> formulation. Usage, in tests/: test_segments RESULT_FILE
program test_segments
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, run_text, channel
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(256) :: results

   call get_command_argument(1, results)
   call check_bending()
   call check_modes()
   call check_driven()
   call check_crank()
   call check_pendulum()
   call check_energy()
   call check_end_mass()
   call check_ring()
   call finish()

contains

   !> A cantilever that a couple at its end rolls up to three turns: with the section at the start as frame its end has turned by
   !> 6 pi, each piece by more than half a turn; from the line through both ends, which meet, rotations have no meaning, and that
   !> is told.
   subroutine check_ring()
      character(*), parameter :: nl = newline
      character(*), parameter :: rest = nl//'*JOINT, NAME=w, TYPE=WELD'//nl//' b.start, ground.origin'//nl// &
         & '*TORQUE, NAME=f, POINT=b.end'//nl//' 6*pi'//nl// &
         & '*STATICS, INCREMENTS=20'//nl//'*OUTPUT'//nl//' turn = rotation(b.end)'//nl
      character(*), parameter :: beam = '*MATERIAL, NAME=m, YOUNG=1e6, DENSITY=1'//nl// &
         & '*SECTION, NAME=s, SHAPE=GENERAL, AREA=100, INERTIA=1e-6'//nl// &
         & '*BEAM, NAME=b, MATERIAL=m, SECTION=s, LENGTH=1, SEGMENTS=5'
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      character(:), allocatable :: report
      call run_text(beam//rest, trim(results), report, error)
      call check_no_error(error, 'a ring')
      call check(index(report, 'from which channels are measured (rotation)') > 0, 'ends that meet are told: '//report)
      call run_text(beam//', SUPPORT=CLAMPED-FREE'//rest, trim(results), report, error)
      call check_no_error(error, 'a ring from its start')
      call check(index(report, 'warning') == 0, 'the section at the start is a frame: '//report)
      call reader%open(trim(results), error)
      call check_close(at_end(channel(reader, 'turn')), 6*acos(-1.0_wp), 1.0e-9_wp, 'three turns')
      call reader%close()
   end subroutine check_ring

   !> A mass at the end of a beam whose pieces do not add up to its length in the last digit.
   subroutine check_end_mass()
      type(history_reader_type) :: reader
      character(60) :: old(3), new(3)
      real(wp), allocatable :: angle(:)
      old = [character(60) :: 'ELEMENTS=8, SUPPORT=CLAMPED-FREE,', 'BENDING MODES=1, AXIAL MODES=1, GEOMETRIC=K_G, ANGLE=0', &
         & 'END=rise + 2*pi/speed, OUTPUTS=400']
      new = [character(60) :: 'SUPPORT=CLAMPED-FREE,', 'SEGMENTS=3, FUNCTIONS=3, ANGLE=0', 'END=0.01, OUTPUTS=4']
      call run_changed('../input/flexible_four_bar.inp', trim(results), old, new, reader)
      angle = channel(reader, 'angle_crank')
      call check(size(angle) == 5, 'a mass at the end of three pieces lies on the beam')
      call reader%close()
   end subroutine check_end_mass

   !> A cantilever under a force at 1.2 and a load that grows with the coordinate between 0.2 and 1.3, by the theory of beams.
   subroutine check_bending()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: place(:)
      real(wp), parameter :: length = 1.5_wp, ei = 2.0e11_wp*0.02_wp*0.01_wp**3/12, force = 3.0e-3_wp, slope = 1.0e-2_wp
      real(wp), parameter :: root_moment = 1.2_wp*force + slope*(1.3_wp**3 - 0.2_wp**3)/3
      call run_changed('verification/segments.inp', trim(results), [character(1) ::], [character(1) ::], reader)
      call expect(reader, 'u2_end', (slope*(3*length*(1.3_wp**4 - 0.2_wp**4)/4 - (1.3_wp**5 - 0.2_wp**5)/5) &
         & + force*1.2_wp**2*(3*length - 1.2_wp))/(6*ei), 1.0e-4_wp)
      call expect(reader, 'turn', (slope*(1.3_wp**4 - 0.2_wp**4)/4 + force*1.2_wp**2)/(2*ei), 1.0e-3_wp)
      call expect(reader, 'moment', slope*((1.3_wp**3 - 0.4_wp**3)/3 - 0.4_wp*(1.3_wp**2 - 0.4_wp**2)/2) + force*0.8_wp, &
         & 1.0e-3_wp)
      call expect(reader, 'shear', slope*(1.3_wp**2 - 0.75_wp**2)/2 + force, 2.0e-2_wp)
      call expect(reader, 'stress', -root_moment*0.005_wp/(0.02_wp*0.01_wp**3/12), 1.0e-3_wp)
      call expect(reader, 'long', length, 1.0e-15_wp)
      call check_close(at_end(channel(reader, 'y_end')), at_end(channel(reader, 'u2_end')), 1.0e-15_wp, 'the frame is the wall''s')
      call check_close(at_end(channel(reader, 'tilt')), 0.0_wp, 1.0e-15_wp, 'angle of the frame')
      call reader%read_numbers('/bodies/arm/envelope/coordinate', place, error)
      call check_no_error(error, 'envelope of the whole beam')
      call check_close(minval(place), 0.0_wp, 1.0e-15_wp, 'envelope from the start')
      call check_close(maxval(place), length, 1.0e-12_wp, 'envelope to the end')
      call check(all(place(2:) >= place(:size(place) - 1) - 1.0e-12_wp), 'envelope in the order of the beam')
      call reader%close()

   end subroutine check_bending

   !> Compares the last value of a channel.
   subroutine expect(reader, name, value, tolerance)
      type(history_reader_type), intent(in) :: reader
      character(*), intent(in) :: name
      !> The value, and what it may be wrong by relatively
      real(wp), intent(in) :: value, tolerance
      call check_close(at_end(channel(reader, name))/value, 1.0_wp, tolerance, name//' of a cantilever in segments')
   end subroutine expect

   !> Frequencies of the bare cantilever.
   subroutine check_modes()
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:)
      real(wp), parameter :: exact(3) = [3.5160152685_wp, 22.0344915647_wp, 61.6972144_wp]
      real(wp) :: unit
      unit = sqrt(2.0e11_wp*0.01_wp**2/12/7850)/1.5_wp**2
      call run_changed('verification/segments.inp', trim(results), [character(12) :: ' outer, 0.2'], &
         & [character(12) :: ' outer, 0'], reader)
      call reader%read_numbers('/modes/shake/frequency', frequency, error)
      call check_no_error(error, 'frequencies')
      call check_close(maxval(abs(frequency(:3)/(exact*unit) - 1)), 0.0_wp, 1.0e-3_wp, 'frequencies of a cantilever in segments')
      call reader%close()
   end subroutine check_modes

   !> A driver, angle and spin of the frame of a beam in segments: that of its clamped end.
   subroutine check_driven()
      type(history_reader_type) :: reader
      character(60) :: old(4), new(4)
      real(wp), allocatable :: tilt(:)
      old = [character(60) :: '*JOINT, NAME=wall, TYPE=WELD, TURN=0', '*STATICS, NAME=bend, INCREMENTS=1', &
         & '*MODES, NAME=shake, NUMBER=3', 'tilt = angle(arm)']
      new = [character(60) :: '*JOINT, NAME=wall, TYPE=REVOLUTE', '*DRIVER, NAME=motor, TYPE=ANGLE, BODY=arm', &
         & ' 9*t', 'tilt = angle(arm), spin = spin(arm)']
      new(3) = ' 9*t'//new_line('a')//'*DYNAMICS, END=1, OUTPUTS=10, TOLERANCE=1e-4'
      call run_changed('verification/segments.inp', trim(results), old, new, reader)
      allocate (tilt, source=channel(reader, 'tilt'))
      call check_close(at_end(tilt), 9.0_wp, 1.0e-9_wp, 'angle over more than a turn')
      call check_close(at_end(channel(reader, 'spin')), 9.0_wp, 1.0e-9_wp, 'spin')
      call reader%close()
   end subroutine check_driven

   !> The rod of 3 mm as it begins to buckle: the largest of four errors, until t = 0.02.
   subroutine check_crank()
      type(history_reader_type) :: reader
      real(wp), parameter :: exact(4) = [0.0495140032_wp, 0.0691877472_wp, 0.1376714248_wp, 0.1983608541_wp]
      integer, parameter :: sample(4) = [100, 120, 160, 200] + 1
      real(wp), allocatable :: deflection(:)
      real(wp) :: error(2)
      character(60) :: old(3), new(3)
      integer :: k
      old = [character(60) :: 'FUNCTIONS=9, STRAIN FUNCTIONS=3', 'END=2*pi/speed', 'OUTPUTS=419']
      do k = 1, 2
         new(1) = 'FUNCTIONS=3, SEGMENTS='//as_text(2**k)
         new(2) = 'END=200/419*2*pi/speed'
         new(3) = 'OUTPUTS=200'
         call run_changed('../input/slider_crank_3mm.inp', trim(results), old, new, reader)
         allocate (deflection, source=channel(reader, 'deflection_over_length'))
         error(k) = maxval(abs(deflection(sample) - exact))
         deallocate (deflection)
         call reader%close()
      end do
      print '(a, 2es10.2)', 'slider-crank, 2 and 4 segments:', error
      call check(error(2) < 5.0e-4_wp, 'slider-crank in 4 segments')
      call check(error(1) < 1.0e-3_wp, 'slider-crank in 2 segments')
   end subroutine check_crank

   !> A rope-like pendulum until it has fallen for 0.4 s: its strains are a tenth and more, so that the order is two at last.
   subroutine check_pendulum()
      type(history_reader_type) :: reader
      character(8), parameter :: names(4) = [character(8) :: 'x_tip', 'y_tip', 'x_middle', 'y_middle']
      real(wp), parameter :: exact(4, 4) = reshape([1.2000000_wp, 1.1799243_wp, 1.0787376_wp, 0.8528493_wp, -0.0490497_wp, &
         & -0.1961870_wp, -0.4412617_wp, -0.7844859_wp, 0.5987043_wp, 0.5681325_wp, 0.4611782_wp, 0.3162151_wp, -0.0490589_wp, &
         & -0.1959110_wp, -0.4423304_wp, -0.5863472_wp], [4, 4])
      real(wp), allocatable :: place(:)
      real(wp) :: error(2)
      character(60) :: old(3), new(3)
      integer :: i, k
      old = [character(60) :: 'FUNCTIONS=40, STRAIN FUNCTIONS=20', 'END=1.1', 'OUTPUTS=220']
      do k = 1, 2
         new(1) = 'FUNCTIONS=3, SEGMENTS='//as_text(4*k)
         new(2) = 'END=0.4'
         new(3) = 'OUTPUTS=4'
         call run_changed('../input/soft_pendulum.inp', trim(results), old, new, reader)
         error(k) = 0.0_wp
         do i = 1, 4
            allocate (place, source=channel(reader, trim(names(i))))
            error(k) = error(k) + sum((place(2:) - exact(:, i))**2)/4
            deallocate (place)
         end do
         error(k) = sqrt(error(k))/1.2_wp
         call reader%close()
      end do
      print '(a, 2es10.2)', 'soft pendulum, 4 and 8 segments:', error
      call check(error(2) < 1.5e-3_wp, 'soft pendulum in 8 segments')
      call check(log(error(1)/error(2))/log(2.0_wp) > 1.3_wp, 'order of the soft pendulum')
   end subroutine check_pendulum

   !> Nothing is lost at the welds: CONSERVING keeps the energy of the falling rope.
   subroutine check_energy()
      type(history_reader_type) :: reader
      real(wp), allocatable :: energy(:)
      character(100) :: old(5), new(5)
      old = [character(100) :: 'FUNCTIONS=40, STRAIN FUNCTIONS=20', 'INTEGRATOR=RADAU', 'END=1.1', 'OUTPUTS=220', &
         & 'y_middle = y(rod.middle)']
      new = [character(100) :: 'FUNCTIONS=3, SEGMENTS=4', 'INTEGRATOR=CONSERVING', 'END=0.3', 'OUTPUTS=30', &
         & 'y_middle = y(rod.middle), e = kinetic_energy(system) + potential_energy(system)']
      call run_changed('../input/soft_pendulum.inp', trim(results), old, new, reader)
      allocate (energy, source=channel(reader, 'e'))
      call check_close(maxval(abs(energy - energy(1))), 0.0_wp, 1.0e-8_wp, 'energy of a beam in segments')
      call reader%close()
   end subroutine check_energy

   pure real(wp) function at_end(values)
      real(wp), intent(in) :: values(:)
      at_end = values(size(values))
   end function at_end

end program test_segments
