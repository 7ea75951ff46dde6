!> Gravity and units. Floor: model.
module limber_model_gravity
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_deck_content, only: deck_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_model_model, only: model_type, units_type
   implicit none
   private
   public :: read_gravity, warn_of_degrees

   !> A unit and its size in SI
   type :: unit_type
      character(4) :: name
      real(wp) :: size
   end type unit_type

   type(unit_type), parameter :: lengths(*) = [unit_type('m', 1.0_wp), unit_type('mm', 1.0e-3_wp), unit_type('cm', 1.0e-2_wp), &
      & unit_type('dm', 1.0e-1_wp), unit_type('km', 1.0e3_wp), unit_type('um', 1.0e-6_wp), unit_type('in', 0.0254_wp), &
      & unit_type('ft', 0.3048_wp), unit_type('yd', 0.9144_wp)]
   type(unit_type), parameter :: times(*) = [unit_type('s', 1.0_wp), unit_type('ms', 1.0e-3_wp), unit_type('us', 1.0e-6_wp), &
      & unit_type('min', 60.0_wp), unit_type('h', 3600.0_wp)]
   !> Gravity on earth, the default of Y; range of numbers that are probably meant as this value [m/s^2]
   real(wp), parameter :: earth = 9.81_wp, likely(2) = [9.7_wp, 9.9_wp]

contains

   !> Reads *GRAVITY. Default: gravity on earth in the units of the deck. Warns of a number near 9.81 in other units than m/s^2.
   subroutine read_gravity(deck, block, model, diagnostics)
      type(deck_type), intent(inout) :: deck
      !> Index of the block
      integer, intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: unit, strength
      unit = acceleration_unit(model%units)
      if (.not. deck%blocks(block)%given('Y')) then
         if (unit > 0.0_wp) then
            if (abs(unit - 1.0_wp) > 0.0_wp) call deck%set_number(block, 'Y', -earth/unit)
         else
            call diagnostics%add(deck%blocks(block)%origin, 'gravity is not known in units of '//model%units%length//' and '// &
               & model%units%time, 'give Y=; units that are known: '//names_of(lengths)//'; '//names_of(times))
         end if
      end if
      model%gravity = [deck%blocks(block)%real('X'), deck%blocks(block)%real('Y')]
      strength = norm2(model%gravity)
      if (deck%blocks(block)%given('Y') .and. abs(unit - 1.0_wp) > 0.01_wp .and. unit > 0.0_wp .and. strength > likely(1) &
         & .and. strength < likely(2)) call diagnostics%warn(deck%blocks(block)%origin_of('Y'), 'gravity of '// &
         & as_text(strength)//' '//model%units%length//'/'//model%units%time//'^2 is '//as_text(strength*unit/earth, 3)// &
         & ' times that of the earth', 'in these units it is '//as_text(earth/unit, 6))
   end subroutine read_gravity

   !> Warns of an angle beyond a full turn: it may be in degrees.
   subroutine warn_of_degrees(deck, block, option, diagnostics)
      type(deck_type), intent(in) :: deck
      !> Index of the block, and name of its option
      integer, intent(in) :: block
      character(*), intent(in) :: option
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), parameter :: turn = 2*acos(-1.0_wp)
      real(wp) :: angle
      if (.not. deck%blocks(block)%given(option)) return
      angle = deck%blocks(block)%real(option)
      if (abs(angle) > turn) call diagnostics%warn(deck%blocks(block)%origin_of(option), option//'='//as_text(angle, 6)// &
         & ' is '//as_text(angle/turn, 3)//' turns: angles are in radians', 'write '//as_text(angle, 6)//' deg for degrees')
   end subroutine warn_of_degrees

   !> Size of the deck's unit of acceleration [m/s^2]; 0 if the units are unknown.
   pure real(wp) function acceleration_unit(units) result(unit)
      type(units_type), intent(in) :: units
      unit = 0.0_wp
      if (size_of(times, units%time) > 0.0_wp) unit = size_of(lengths, units%length)/size_of(times, units%time)**2
   end function acceleration_unit

   !> Size of a unit in SI; 0 if it is unknown.
   pure real(wp) function size_of(units, name)
      type(unit_type), intent(in) :: units(:)
      character(*), intent(in) :: name
      size_of = sum(units%size, mask=units%name == name)
   end function size_of

   !> Names of units, with commas between them.
   pure function names_of(units) result(text)
      type(unit_type), intent(in) :: units(:)
      character(:), allocatable :: text
      integer :: i
      text = trim(units(1)%name)
      do i = 2, size(units)
         text = text//', '//trim(units(i)%name)
      end do
   end function names_of

end module limber_model_gravity
