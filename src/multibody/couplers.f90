!> Linear couplers of joint coordinates. Sums of parts of at most two bodies, which share an equation. Floor: multibody. Source:
!> doc/theory, eq. (3.21).
module limber_multibody_couplers
   use limber_base_kinds, only: wp
   use limber_model_model, only: term_type, coordinate_displacement, ground
   use limber_multibody_constraint, only: constraint_type
   use limber_multibody_function_constraints, only: linear_type, most_measures, most_vectors
   use limber_multibody_joint_functions, only: joint_function_type
   use limber_multibody_marker_registry, only: registry_type
   use limber_multibody_function_sums, only: add_coordinate, add_measure, find_bodies, vector
   implicit none
   private
   public :: add_coupler

contains

   !> A linear coupling of joint coordinates: the sum of parts of at most two bodies, eq. (3.21).
   subroutine add_coupler(system, index, item, parts)
      class(registry_type), intent(inout) :: system
      integer, intent(in) :: index
      class(constraint_type), allocatable, intent(out) :: item
      type(linear_type), allocatable, intent(inout) :: parts(:)
      type(linear_type), allocatable :: own(:)
      real(wp) :: sum
      integer :: i
      sum = 0.0_wp
      allocate (own(0))
      do i = 1, size(system%model%joints(index)%terms)
         call add_term(system, system%model%joints(index)%terms(i), own, sum)
      end do
      associate (joint => system%model%joints(index))
         own%driven = joint%has_law
         own%scale = maxval(abs(joint%terms%coefficient)*merge(system%model%length, 1.0_wp, &
            & joint%terms%kind == coordinate_displacement))
         if (.not. own(1)%scale > 0.0_wp) own%scale = 1.0_wp
         own(2:)%part_of = index
         if (joint%has_law) own(1)%drive = size(system%model%drivers) + count(system%model%joints(:index)%has_law)
         if (.not. joint%has_law) own(1)%offset(1) = sum
      end associate
      allocate (item, source=own(1))
      do i = 2, size(own)
         call append_part(parts, own(i))
      end do
   end subroutine add_coupler

   !> Adds the measures of a joint coordinate, each to the first part that has its bodies, or room for them.
   subroutine add_term(system, term, parts, sum)
      class(registry_type), intent(inout) :: system
      type(term_type), intent(in) :: term
      type(linear_type), allocatable, intent(inout) :: parts(:)
      !> Receives the term's value in the first guess
      real(wp), intent(inout) :: sum
      type(linear_type) :: single, empty
      integer :: k, i
      empty%rows = 1
      call add_coordinate(system, single, term, sum)
      do k = 1, single%count
         do i = 1, size(parts)
            if (has_room(system, parts(i), single, k)) exit
         end do
         if (i > size(parts)) call append_part(parts, empty)
         call move_measure(single, k, parts(i))
         call find_bodies(system, parts(i))
      end do
   end subroutine add_term

   !> Whether a part can take a measure: then it is still one of two bodies.
   pure logical function has_room(system, part, single, measure) result(room)
      class(registry_type), intent(in) :: system
      type(linear_type), intent(in) :: part, single
      integer, intent(in) :: measure
      integer :: bodies(2), j, body
      room = .false.
      if (part%count == most_measures .or. part%vectors + 3 > most_vectors) return
      bodies = part%bodies
      do j = 1, 3
         if (single%measures(measure)%vectors(j) == 0) cycle
         body = system%model%points(system%marker_points(single%markers(single%measures(measure)%vectors(j))))%body
         if (body == ground .or. any(bodies == body)) cycle
         if (all(bodies /= ground)) return
         bodies(merge(1, 2, bodies(1) == ground)) = body
      end do
      room = .true.
   end function has_room

   !> Adds a measure of one constraint to another, with its coefficient in the first row.
   subroutine move_measure(from, index, to)
      type(linear_type), intent(in) :: from
      integer, intent(in) :: index
      type(linear_type), intent(inout) :: to
      type(joint_function_type) :: measure
      integer :: j
      measure = from%measures(index)
      do j = 1, 3
         if (measure%vectors(j) > 0) measure%vectors(j) = vector(to, from%markers(measure%vectors(j)))
      end do
      call add_measure(to, measure, from%coefficients(1, index), 1)
   end subroutine move_measure

   !> One more part at the end of a list.
   subroutine append_part(parts, part)
      type(linear_type), allocatable, intent(inout) :: parts(:)
      type(linear_type), intent(in) :: part
      type(linear_type), allocatable :: longer(:)
      allocate (longer(size(parts) + 1))
      longer(:size(parts)) = parts
      longer(size(longer)) = part
      call move_alloc(longer, parts)
   end subroutine append_part

end module limber_multibody_couplers
