!> Linear couplers of joint coordinates. Sums of parts of at most two bodies, which share an equation; a coordinate along a
!> beam is a part by itself. Floor: multibody. Source: doc/theory, eq. (3.21).
module limber_multibody_couplers
   use limber_base_kinds, only: wp
   use limber_model_model, only: term_type, coordinate_displacement, ground
   use limber_multibody_constraint, only: constraint_type, constraint_item_type
   use limber_multibody_function_constraints, only: function_constraint_type, linear_type, most_functions, most_vectors
   use limber_multibody_marker_registry, only: registry_type
   use limber_multibody_function_sums, only: add_coordinate, add_scalar, find_bodies
   use limber_multibody_beam_path, only: beam_path_type
   use limber_multibody_sliding_paths, only: new_coordinate, slides
   implicit none
   private
   public :: add_coupler

contains

   !> A linear coupling of joint coordinates: the sum of parts of at most two bodies, eq. (3.21).
   subroutine add_coupler(system, index, item, parts)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      !> Receives the parts behind the first
      type(constraint_item_type), allocatable, intent(inout) :: parts(:)
      type(linear_type), allocatable :: linear(:)
      type(constraint_item_type), allocatable :: own(:)
      class(beam_path_type), allocatable :: path
      real(wp) :: sum, guess
      integer :: i
      sum = 0.0_wp
      allocate (linear(0), own(0))
      do i = 1, size(system%model%joints(index)%terms)
         associate (term => system%model%joints(index)%terms(i))
            if (is_along_beam(system, term)) then
               call new_coordinate(system, system%model%joints(term%of), term%coefficient, path, guess)
               sum = sum + guess
               call append_part(own, path)
            else
               call add_term(system, term, linear, sum)
            end if
         end associate
      end do
      do i = 1, size(linear)
         call append_part(own, linear(i))
      end do
      associate (joint => system%model%joints(index))
         do i = 1, size(own)
            own(i)%item%driven = joint%has_law
            own(i)%item%scale = maxval(abs(joint%terms%coefficient)*merge(system%model%length, 1.0_wp, &
               & joint%terms%kind == coordinate_displacement))
            if (.not. own(i)%item%scale > 0.0_wp) own(i)%item%scale = 1.0_wp
            if (i > 1) own(i)%item%part_of = index
         end do
         if (.not. joint%has_law) call set_sum(own(1)%item, sum)
         if (joint%has_law) call set_drive(own(1)%item, size(system%model%drivers) &
            & + count(system%model%joints(:index)%has_law))
      end associate
      call move_alloc(own(1)%item, item)
      do i = 2, size(own)
         call append_part(parts, own(i)%item)
      end do
   end subroutine add_coupler

   !> What the sum keeps.
   subroutine set_sum(part, sum)
      class(constraint_type), intent(inout) :: part
      real(wp), intent(in) :: sum
      select type (part)
      type is (linear_type)
         part%offset(1) = sum
         part%keeps = .true.
      class is (beam_path_type)
         part%offset = part%offset + sum
      end select
   end subroutine set_sum

   !> What moves the sum.
   subroutine set_drive(part, drive)
      class(constraint_type), intent(inout) :: part
      integer, intent(in) :: drive
      select type (part)
      class is (function_constraint_type)
         part%drive = drive
      end select
   end subroutine set_drive

   !> One more part at the end of a list.
   subroutine append_part(parts, part)
      type(constraint_item_type), allocatable, intent(inout) :: parts(:)
      class(constraint_type), intent(in) :: part
      type(constraint_item_type), allocatable :: longer(:)
      integer :: k
      allocate (longer(size(parts) + 1))
      do k = 1, size(parts)
         call move_alloc(parts(k)%item, longer(k)%item)
      end do
      allocate (longer(size(longer))%item, source=part)
      call move_alloc(longer, parts)
   end subroutine append_part

   !> Whether a term is a coordinate along a beam.
   pure logical function is_along_beam(system, term) result(along)
      class(registry_type), intent(in) :: system
      type(term_type), intent(in) :: term
      along = term%kind == coordinate_displacement
      if (along) along = slides(system%model%joints(term%of))
   end function is_along_beam

   !> Adds the scalar functions of a joint coordinate, each to the first part that has its bodies, or room for them.
   subroutine add_term(system, term, parts, sum)
      class(registry_type), intent(inout) :: system
      type(term_type), intent(in) :: term
      type(linear_type), allocatable, intent(inout) :: parts(:)
      !> Receives the term's value in the first guess
      real(wp), intent(inout) :: sum
      type(linear_type) :: single
      integer :: k, i
      call add_coordinate(system, single, term, sum)
      do k = 1, single%count
         do i = 1, size(parts)
            if (has_room(system, parts(i), single, k)) exit
         end do
         if (i > size(parts)) call add_empty(parts)
         call add_scalar(parts(i), single%functions(k), single%coefficients(1, k), 1)
         call find_bodies(system, parts(i))
      end do
   end subroutine add_term

   !> One more part at the end of a list.
   subroutine add_empty(parts)
      type(linear_type), allocatable, intent(inout) :: parts(:)
      type(linear_type), allocatable :: longer(:)
      allocate (longer(size(parts) + 1))
      longer(:size(parts)) = parts
      longer(size(longer))%rows = 1
      call move_alloc(longer, parts)
   end subroutine add_empty

   !> Whether a part can take a scalar function: then it is still one of two bodies.
   pure logical function has_room(system, part, single, index) result(room)
      class(registry_type), intent(in) :: system
      type(linear_type), intent(in) :: part, single
      !> Which of the functions of the single one
      integer, intent(in) :: index
      integer :: bodies(2), j, body
      room = .false.
      if (part%count == most_functions .or. part%vectors + 3 > most_vectors) return
      bodies = part%bodies
      do j = 1, 3
         if (single%functions(index)%markers(j) == 0) cycle
         body = system%model%points(system%marker_points(single%functions(index)%markers(j)))%body
         if (body == ground .or. any(bodies == body)) cycle
         if (all(bodies /= ground)) return
         bodies(merge(1, 2, bodies(1) == ground)) = body
      end do
      room = .true.
   end function has_room

end module limber_multibody_couplers
