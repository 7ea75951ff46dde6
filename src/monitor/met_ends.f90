!> Monitor of lines through both ends of a beam. What channels measure from there has no meaning where the ends meet: the line has
!> no direction then, and may turn by half a turn from one sample to the next. Floor: monitor. Source: doc/theory, eq. (2.61).
module limber_monitor_met_ends
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text, newline
   use limber_model_beam_segments, only: name_in_deck
   use limber_model_quantities, only: quantities, quantity_deflection, quantity_u1, quantity_u2, quantity_rotation, &
      & quantity_angle, quantity_spin, quantity_force_1, quantity_force_2
   use limber_model_model, only: model_type, quantity_type, body_flexible, ground
   use limber_multibody_point_motion, only: point_position
   use limber_multibody_system, only: system_type
   implicit none
   private
   public :: met_ends_type, start_met_ends, observe_met_ends, join_met_ends, met_ends_warnings

   !> Distance of the ends, of the length, below which it is told
   real(wp), parameter :: near = 0.1_wp

   !> One beam
   type :: ends_type
      !> One of its bodies, its ends, and its length
      integer :: body = 0, points(2) = 0
      real(wp) :: length = 0.0_wp
      !> What is measured from the line, and whether that may be measured from the section at the start as well
      logical :: asked(size(quantities)) = .false., of_frame = .false.
      !> Least distance of the ends, of the length, and when
      real(wp) :: nearest = huge(1.0_wp), when = 0.0_wp
   end type ends_type

   !> All beams of which channels ask something that is measured so
   type :: met_ends_type
      type(ends_type), allocatable :: lines(:)
   contains
      procedure :: exchange => exchange_met_ends
   end type met_ends_type

contains

   !> The beams, and what is asked of them.
   subroutine start_met_ends(self, model)
      type(met_ends_type), intent(inout) :: self
      type(model_type), intent(in) :: model
      integer :: i, k
      if (allocated(self%lines)) deallocate (self%lines)
      allocate (self%lines(0))
      do i = 1, size(model%channels)
         do k = 1, size(model%channels(i)%quantities)
            call add_quantity(self, model, model%channels(i)%quantities(k))
         end do
      end do
   end subroutine start_met_ends

   !> Adds what one quantity asks for.
   subroutine add_quantity(self, model, quantity)
      type(met_ends_type), intent(inout) :: self
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      type(ends_type) :: line
      integer :: body, i
      logical :: of_frame
      call find_beam(model, quantity, body, of_frame)
      if (body == ground) return
      line%body = body
      associate (own => model%bodies(body))
         line%length = own%beam%length
         line%points = [own%start_point, own%end_point]
         if (own%whole > 0) then
            line%length = model%wholes(own%whole)%length
            associate (first => model%bodies(model%wholes(own%whole)%first))
               line%points = [first%start_point, first%end_point]
            end associate
         end if
      end associate
      if (any(line%points == 0)) return
      do i = 1, size(self%lines)
         if (all(self%lines(i)%points == line%points)) exit
      end do
      if (i > size(self%lines)) self%lines = [self%lines, line]
      self%lines(i)%of_frame = self%lines(i)%of_frame .or. of_frame
      self%lines(i)%asked(quantity%kind) = .true.
   end subroutine add_quantity

   !> The exact beam of a quantity that is measured from the line through its ends; `ground`: there is none.
   subroutine find_beam(model, quantity, body, of_frame)
      type(model_type), intent(in) :: model
      type(quantity_type), intent(in) :: quantity
      integer, intent(out) :: body
      !> Whether the line is the frame of a beam in segments
      logical, intent(out) :: of_frame
      integer :: point
      body = ground
      of_frame = .false.
      if (quantity%of <= 0 .or. quantity%of_load .or. quantity%of_coupler) return
      point = 0
      select case (quantity%kind)
      case (quantity_deflection, quantity_u1, quantity_u2, quantity_rotation)
         point = quantity%of
      case (quantity_angle, quantity_spin)
         body = quantity%of
      case (quantity_force_1, quantity_force_2)
         if (quantity%of <= size(model%joints)) point = model%joints(quantity%of)%points(2)
      end select
      if (point > 0) body = model%points(point)%body
      if (body == ground) return
      if (model%bodies(body)%kind /= body_flexible .or. .not. model%bodies(body)%reduced%is_exact) then
         body = ground
      else if (quantity%kind /= quantity_deflection) then
         of_frame = model%bodies(body)%whole > 0
         if (of_frame) of_frame = .not. (model%wholes(model%bodies(body)%whole)%clamped .or. &
            & allocated(model%wholes(model%bodies(body)%whole)%lean))
         if (.not. of_frame) body = ground
      end if
   end subroutine find_beam

   !> Takes in a state.
   subroutine observe_met_ends(self, system, t, q)
      type(met_ends_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Time; coordinates (nq)
      real(wp), intent(in) :: t, q(:)
      real(wp) :: distance
      integer :: i
      do i = 1, size(self%lines)
         associate (line => self%lines(i), points => system%model%points)
            distance = norm2(point_position(system%model, system%layout, points(line%points(2)), q) &
               & - point_position(system%model, system%layout, points(line%points(1)), q))/line%length
            if (distance >= line%nearest) cycle
            line%nearest = distance
            line%when = t
         end associate
      end do
   end subroutine observe_met_ends

   !> A warning for each beam whose ends meet.
   function met_ends_warnings(self, model) result(text)
      type(met_ends_type), intent(in) :: self
      type(model_type), intent(in) :: model
      character(:), allocatable :: text, asked
      integer :: i, k
      text = ''
      if (.not. allocated(self%lines)) return
      do i = 1, size(self%lines)
         associate (line => self%lines(i))
            if (line%nearest > near) cycle
            asked = ''
            do k = 1, size(quantities)
               if (line%asked(k)) asked = asked//', '//trim(quantities(k)%name)
            end do
            text = text//"warning: the ends of beam '"//name_in_deck(model, line%body)//"' are "//as_text(100*line%nearest, 2)// &
               & ' % of its length from each other at t = '//as_text(line%when, 4)//': the line through both, from which '// &
               & 'channels are measured ('//asked(3:)//'), has next to no direction there and may turn by half'// &
               & ' a turn; use x and y of points'
            if (line%of_frame) text = text//', or SUPPORT=CLAMPED-FREE, which measures from the section at the start'
            text = text//newline
         end associate
      end do
   end function met_ends_warnings

   !> Joins what an analysis has seen to that of those before.
   subroutine join_met_ends(part, whole)
      type(met_ends_type), intent(in) :: part
      type(met_ends_type), intent(inout) :: whole
      integer :: i
      do i = 1, size(whole%lines)
         if (part%lines(i)%nearest >= whole%lines(i)%nearest) cycle
         whole%lines(i)%nearest = part%lines(i)%nearest
         whole%lines(i)%when = part%lines(i)%when
      end do
   end subroutine join_met_ends

   !> Saves or restores it.
   subroutine exchange_met_ends(self, snapshot)
      class(met_ends_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      if (.not. allocated(self%lines)) return
      do i = 1, size(self%lines)
         call snapshot%exchange('nearest', self%lines(i)%nearest)
         call snapshot%exchange('nearest_when', self%lines(i)%when)
      end do
   end subroutine exchange_met_ends

end module limber_monitor_met_ends
