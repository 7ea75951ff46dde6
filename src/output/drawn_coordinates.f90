!> Coordinates of a sample for drawings. Of each body those of its frame and of its deflection; of an exact beam, whose places are
!> no sums of shapes, the displacements of all places that are drawn of it. Floor: output.
module limber_output_drawn_coordinates
   use limber_base_kinds, only: wp
   use limber_beam_exact_beam, only: reach_of, undeformed_place
   use limber_model_model, only: model_type
   use limber_multibody_beam_place, only: find_place
   use limber_multibody_layout, only: layout_type
   implicit none
   private
   public :: drawn_type, new_drawn, drawn_width, body_width, drawn_coordinates, drawn_shape, drawn_place
   public :: named_places, stretches_of_beam

   !> Least number of stretches of a beam's outline, and stretches for each bending coordinate
   integer, parameter :: least_stretches = 24, stretches_per_mode = 6

   !> Places that are drawn of an exact beam: named points first, then stations at equal distances
   type :: drawn_type
      integer :: body = 0
      !> What the stations of the beam give to each (stations, places); where they are undeformed (2, places)
      real(wp), allocatable :: reach(:, :), p0(:, :)
   end type drawn_type

contains

   !> The exact beams of a model.
   pure function new_drawn(model) result(drawn)
      type(model_type), intent(in) :: model
      type(drawn_type), allocatable :: drawn(:)
      integer :: i, k
      allocate (drawn(count([(model%bodies(i)%reduced%is_exact, i=1, size(model%bodies))])))
      k = 0
      do i = 1, size(model%bodies)
         if (.not. model%bodies(i)%reduced%is_exact) cycle
         k = k + 1
         call find_places(model, i, drawn(k))
      end do
   end function new_drawn

   !> The places of one beam.
   pure subroutine find_places(model, body, drawn)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      type(drawn_type), intent(inout) :: drawn
      integer :: i, k, n
      n = stretches_of_beam(model, body)
      drawn%body = body
      associate (exact => model%bodies(body)%reduced%exact)
         allocate (drawn%reach(exact%stations, named_places(model, body) + n + 1), drawn%p0(2, named_places(model, body) + n + 1))
         k = 0
         do i = 1, size(model%points)
            if (model%points(i)%body /= body .or. .not. allocated(model%points(i)%reach)) cycle
            k = k + 1
            drawn%reach(:, k) = model%points(i)%reach
            drawn%p0(:, k) = model%points(i)%p0
         end do
         do i = 0, n
            drawn%reach(:, k + 1 + i) = reach_of(exact, exact%total*i/n) - exact%base
            drawn%p0(:, k + 1 + i) = undeformed_place(exact, exact%total*i/n)
         end do
      end associate
   end subroutine find_places

   !> Number of points of an exact beam that move with its axis.
   pure integer function named_places(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      integer :: i
      named_places = 0
      do i = 1, size(model%points)
         if (model%points(i)%body == body .and. allocated(model%points(i)%reach)) named_places = named_places + 1
      end do
   end function named_places

   !> Index of a point among the drawn places of its beam, an exact one; 0: it does not move in the frame.
   pure integer function drawn_place(model, point) result(place)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      integer :: i
      place = 0
      if (.not. allocated(model%points(point)%reach)) return
      do i = 1, point
         if (model%points(i)%body == model%points(point)%body .and. allocated(model%points(i)%reach)) place = place + 1
      end do
   end function drawn_place

   !> Number of stretches of a beam's outline.
   pure integer function stretches_of_beam(model, body) result(stretches)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      stretches = max(least_stretches, stretches_per_mode*model%bodies(body)%reduced%bending)
   end function stretches_of_beam

   !> Number of coordinates that are drawn of a body: of a state of a control none.
   pure integer function body_width(model, layout, body) result(width)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      integer, intent(in) :: body
      width = 0
      if (layout%carries(body)) return
      width = merge(4, 2, layout%framed(body)) + layout%n(body)
      if (model%bodies(body)%reduced%is_exact) width = 4 + 2*(named_places(model, body) + stretches_of_beam(model, body) + 1)
   end function body_width

   !> Of all bodies.
   pure integer function drawn_width(model, layout) result(width)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      integer :: i
      width = 0
      do i = 1, size(layout%q)
         width = width + body_width(model, layout, i)
      end do
   end function drawn_width

   !> Displacement for each drawn coordinate of an exact beam: of one of its places, or of one that does not move in its frame.
   pure function drawn_shape(model, layout, body, place) result(phi)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      !> Index of the beam; of the place among those drawn of it, 0: none of them
      integer, intent(in) :: body, place
      real(wp) :: phi(2, body_width(model, layout, body) - 4)
      phi = 0.0_wp
      if (place == 0) return
      phi(1, 2*place - 1) = 1.0_wp
      phi(2, 2*place) = 1.0_wp
   end function drawn_shape

   !> The coordinates of a sample.
   subroutine drawn_coordinates(drawn, model, layout, q, values)
      !> Of the model
      type(drawn_type), intent(in) :: drawn(:)
      type(model_type), intent(in) :: model
      type(layout_type), intent(in) :: layout
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> (drawn_width)
      real(wp), intent(inout) :: values(:)
      real(wp) :: p(2)
      integer :: i, k, j, at, first, n
      at = 0
      k = 0
      do i = 1, size(layout%q)
         if (layout%carries(i)) cycle
         first = layout%q(i)
         n = layout%n(i)
         if (.not. model%bodies(i)%reduced%is_exact) then
            values(at + 1:at + merge(4, 2, layout%framed(i)) + n) = q(first:first + merge(3, 1, layout%framed(i)) + n)
            at = at + merge(4, 2, layout%framed(i)) + n
            cycle
         end if
         k = k + 1
         values(at + 1:at + 4) = q(first:first + 3)
         at = at + 4
         do j = 1, size(drawn(k)%p0, 2)
            call find_place(model%bodies(i)%reduced%exact, drawn(k)%reach(:, j), q(first + 4:first + 3 + n), p)
            values(at + 1:at + 2) = p - drawn(k)%p0(:, j)
            at = at + 2
         end do
      end do
   end subroutine drawn_coordinates

end module limber_output_drawn_coordinates
