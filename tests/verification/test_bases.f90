!> Bases of flexible bodies: a clamped and pinned beam against closed forms, the slider-crank against a converged geometrically
!> exact solution, a portal frame against all modes of its mesh; each by vibration modes, free ones, with corrections, the portal
!> by those of Craig and Bampton, too. Usage, in tests/: test_bases RESULT_FILE
program test_bases
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_base_text, only: newline
   use limber_commands_check, only: check_deck
   use limber_deck_parameters, only: override_type
   use limber_output_history_reader, only: history_reader_type
   use runs, only: run_changed, change_deck, channel, read_columns
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   character(256) :: results
   !> Attachments where something acts, by names and by coordinates
   character(*), parameter :: attached = newline//'*ATTACHMENT'//newline//' start, 1'//newline//' start, 2'//newline// &
      & ' start, 6'//newline//' end, 2'//newline//' loaded, 1'//newline//' 0.8, 2'//newline//' twisted, 6'

   call get_command_argument(1, results)
   call check_clamped_pinned('CORRECTIONS=NO, SUPPORT=PINNED-ROLLER', .false.)
   call check_clamped_pinned('CORRECTIONS=YES, SUPPORT=PINNED-ROLLER', .true.)
   call check_clamped_pinned('CORRECTIONS=YES, SUPPORT=FREE-FREE', .true.)
   call check_clamped_pinned('CORRECTIONS=YES, SUPPORT=CLAMPED-FREE', .true.)
   call check_clamped_pinned('CORRECTIONS=NO, SUPPORT=PINNED-ROLLER', .true., attached)
   call check_note()
   call check_slider_crank()
   call check_portal()
   call finish()

contains

   !> Three bending modes and one axial, alone or with what holds the wall's couple and the loads: two frequencies, and the places,
   !> the moment and the tension under loads, which are exact at the nodes.
   subroutine check_clamped_pinned(basis, holds, attachments)
      !> What stands for the basis in the deck
      character(*), intent(in) :: basis
      !> Whether it holds what acts on the beam
      logical, intent(in) :: holds
      !> Lines of the deck behind the points of the beam
      character(*), intent(in), optional :: attachments
      real(wp), parameter :: root(2) = [3.926602_wp, 7.068583_wp]
      real(wp), parameter :: l = 2.0_wp, a = 0.8_wp, c = 1.35_wp, force = 3.0e-6_wp, couple = 2.0e-6_wp
      type(history_reader_type) :: reader
      type(error_type), allocatable :: error
      real(wp), allocatable :: frequency(:), across(:), slope(:), moment(:), tension(:), along(:)
      real(wp) :: pin, exact(3), wrong
      character(150) :: old(2), new(2)
      old(1) = 'CORRECTIONS=NO, SUPPORT=PINNED-ROLLER'
      new(1) = basis
      old(2) = 'twisted, 1.35'
      new(2) = old(2)
      if (present(attachments)) new(2) = trim(old(2))//attachments
      call run_changed('verification/clamped_pinned.inp', trim(results), old, new, reader)
      call reader%read_numbers('/modes/vibrations/frequency', frequency, error)
      call check_no_error(error, basis)
      allocate (across, source=channel(reader, 'across'))
      allocate (slope, source=channel(reader, 'slope'))
      allocate (moment, source=channel(reader, 'moment'))
      allocate (tension, source=channel(reader, 'tension'))
      allocate (along, source=channel(reader, 'along'))
      wrong = maxval(abs(frequency/(root**2/l**2) - 1.0_wp))
      ! What the pin takes, then deflection, slope and moment at the wall by superposition
      pin = 3/l**3*(force*a**2*(3*l - a)/6 + couple*c*(2*l - c)/2)
      exact = [force*a**3/3 + couple*a**2/2 - pin*a**2*(3*l - a)/6, force*a**2/2 + couple*c - pin*(c*l - c**2/2), &
         & force*a + couple - pin*l]
      associate (n => size(across))
         if (holds) then
            call check_close(wrong, 0.0_wp, 1.0e-2_wp, basis//': frequencies')
            call check_close(across(n), exact(1), 1.0e-6_wp*exact(1), basis//': deflection')
            call check_close(slope(n), exact(2), 1.0e-6_wp*exact(2), basis//': slope')
            call check_close(moment(n), exact(3), 1.0e-6_wp*exact(3), basis//': moment at the wall')
            call check_close(along(n), 1.0e-8_wp*a, 1.0e-6_wp*1.0e-8_wp*a, basis//': displacement along')
         else
            call check(wrong > 0.1_wp, basis//': modes without moment at the wall are too stiff')
            call check(across(n) < 0.5_wp*exact(1), basis//': and do not give way')
         end if
         call check_close(tension(n), 1.0e-5_wp, 1.0e-11_wp, basis//': tension')
      end associate
      print '(2a,2es10.2)', basis, ': errors of frequencies and deflection', wrong, &
         & abs(across(size(across)) - exact(1))/exact(1)
      call reader%close()
   end subroutine check_clamped_pinned

   !> What depends on all the modes that there are is left out with a note.
   subroutine check_note()
      type(error_type), allocatable :: error
      type(override_type) :: none(0)
      character(:), allocatable :: report
      call change_deck('verification/clamped_pinned.inp', trim(results)//'.inp', [character(20) :: 'BENDING MODES=3', &
         & 'CORRECTIONS=NO'], [character(20) :: 'BENDING MODES=39', 'CORRECTIONS=YES'])
      call check_deck(trim(results)//'.inp', none, report, error)
      call check_no_error(error, 'a note')
      call check(index(report, '3 bending functions depend on others and are left out') > 0, 'what is left out is said')
   end subroutine check_note

   !> The same motion in one revolution, whatever the basis: errors against the exact solution. What acts at the pins must join
   !> free modes, which have no shear force there.
   subroutine check_slider_crank()
      real(wp) :: table(7, 839)
      call read_columns('reference/slider_crank_6mm.csv', table)
      ! The error of K_G itself, which is the same in any basis that holds what acts
      call compare(table, 'K_G, SUPPORT=PINNED-ROLLER', 1.4e-2_wp, 1.9e-2_wp)
      call compare(table, 'K_G, SUPPORT=FREE-FREE, CORRECTIONS=YES', 1.75e-2_wp, 1.9e-2_wp)
   end subroutine check_slider_crank

   subroutine compare(table, basis, least, most)
      !> Columns of the reference
      real(wp), intent(in) :: table(:, :)
      !> Fidelity and basis, as the deck has them; bounds of the error
      character(*), intent(in) :: basis
      real(wp), intent(in) :: least, most
      character(160) :: old(4), new(4)
      type(history_reader_type) :: reader
      real(wp), allocatable :: w(:)
      real(wp) :: wrong
      old = [character(160) :: 'turns = 2', 'FUNCTIONS=7, STRAIN FUNCTIONS=3', 'OUTPUTS=838', 'TOLERANCE=1e-8']
      new = [character(160) :: 'turns = 1', &
         & 'ELEMENTS=100, BENDING MODES=3, AXIAL BASIS=STATIC, GEOMETRIC ELEMENTS=12, GEOMETRIC=', &
         & 'OUTPUTS=419', 'TOLERANCE=1e-6, INTEGRATOR=RADAU']
      new(2) = trim(new(2))//basis
      call run_changed('../input/slider_crank_exact.inp', trim(results), old, new, reader)
      allocate (w, source=channel(reader, 'deflection_over_length'))
      wrong = maxval(abs(w - table(3, :420)))/maxval(abs(table(3, :420)))
      print '(2a,es10.2)', basis, ': error of the slider-crank', wrong
      call check_close(wrong, 0.5_wp*(least + most), 0.5_wp*(most - least), basis//': error of the deflection')
      call reader%close()
   end subroutine compare

   !> A portal under a force at a knee that swells and fades, with all modes of its mesh, and with few of them.
   subroutine check_portal()
      real(wp), allocatable :: all_modes(:, :)
      real(wp) :: wrong(3)
      call run_portal('MODES=47', all_modes)
      wrong = portal_errors('MODES=4', all_modes)
      call check(wrong(1) > 1.0e-4_wp .and. wrong(2) > 1.0e-3_wp, 'four modes leave out what the force bends')
      wrong = portal_errors('MODES=4, CORRECTIONS=YES', all_modes)
      call check(maxval(wrong(:2)) < 2.0e-5_wp .and. wrong(3) < 1.0e-4_wp, 'corrections hold it')
      wrong = portal_errors('MODES=7, BASIS=CRAIG-BAMPTON', all_modes)
      call check(maxval(wrong) < 1.5e-3_wp, 'Craig and Bampton')
      wrong = portal_errors('FREQUENCY LIMIT=1500, CORRECTIONS=YES', all_modes)
      call check(maxval(wrong) < 1.0e-6_wp, 'ten modes and corrections')
   end subroutine check_portal

   function portal_errors(basis, all_modes) result(wrong)
      character(*), intent(in) :: basis
      real(wp), intent(in) :: all_modes(:, :)
      real(wp) :: wrong(3)
      real(wp), allocatable :: few(:, :)
      call run_portal(basis, few)
      wrong = maxval(abs(few - all_modes), dim=2)/maxval(abs(all_modes), dim=2)
      print '(2a,3es10.2)', basis, ': errors of the portal', wrong
   end function portal_errors

   subroutine run_portal(basis, values)
      character(*), intent(in) :: basis
      !> Sway and turn of the knee, moment at the foot (3, samples)
      real(wp), allocatable, intent(out) :: values(:, :)
      type(history_reader_type) :: reader
      character(80) :: old(6), new(6)
      real(wp), allocatable :: sway(:)
      old = [character(80) :: 'MODES=6, GEOMETRIC=LINEAR, DIVISIONS=12', ' load, 0', &
         & 'END=4, OUTPUTS=1000, TOLERANCE=1e-7', 'u1(portal.knee), rotation(portal.knee)', &
         & ' bending_moment(portal.left-foot)', '*OUTPUT, ENVELOPE=portal']
      new = [character(80) :: '', ' load*(1 - cos(20*t)), 0', 'END=0.5, OUTPUTS=100, TOLERANCE=1e-8, INTEGRATOR=RADAU', &
         & 'sway = u1(portal.knee), turn = rotation(portal.knee)', ' moment = bending_moment(portal.left-foot)', '']
      new(1) = basis//', GEOMETRIC=LINEAR, DIVISIONS=6'
      call run_changed('../input/portal_frame.inp', trim(results), old, new, reader)
      allocate (sway, source=channel(reader, 'sway'))
      allocate (values(3, size(sway)))
      values(1, :) = sway
      values(2, :) = channel(reader, 'turn')
      values(3, :) = channel(reader, 'moment')
      call reader%close()
   end subroutine run_portal

end program test_bases
