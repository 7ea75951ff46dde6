!> Named points and how references to them are found. Floor: model.
module limber_model_points
   use limber_base_kinds, only: wp
   use limber_base_text, only: nearest_name, lowercase
   use limber_deck_diagnostics, only: diagnostics_type, max_shown
   use limber_deck_origin, only: origin_type
   use limber_model_lists, only: append
   use limber_model_model, only: model_type, point_type
   implicit none
   private
   public :: add_point, find_point, find_body, find_named, enter_name

contains

   !> Appends a point; its index is then the number of points in `counts`.
   subroutine add_point(model, name, body, p0, phi, psi, reach)
      type(model_type), intent(inout) :: model
      !> Name of the body and of the point: 'rod.middle'
      character(*), intent(in) :: name
      !> Index of the body, or `ground`
      integer, intent(in) :: body
      !> Undeformed place in the body frame (2) [length]
      real(wp), intent(in) :: p0(2)
      !> Displacement (2,n) and rotation (n) for each coordinate of a flexible body
      real(wp), intent(in), optional :: phi(:, :), psi(:)
      !> Of a point of an exact beam: what its stations give to the place (stations)
      real(wp), intent(in), optional :: reach(:)
      type(point_type) :: point
      point%name = name
      point%body = body
      point%p0 = p0
      if (present(phi)) then
         allocate (point%phi, source=phi)
         allocate (point%psi, source=psi)
      else
         allocate (point%phi(2, 0), point%psi(0))
      end if
      if (present(reach)) then
         point%exact = .true.
         allocate (point%reach, source=reach)
      end if
      call append(model%points, model%counts%points, point)
      call enter_name(model, 'point', name, model%counts%points)
   end subroutine add_point

   !> Makes an object known by its name; of equal names the first one counts.
   subroutine enter_name(model, kind, name, index)
      type(model_type), intent(inout) :: model
      !> 'point', 'body', 'joint', ...; its name, and its index in the list of its kind
      character(*), intent(in) :: kind, name
      integer, intent(in) :: index
      if (model%names%find(kind//' '//name) == 0) call model%names%add(kind//' '//name, index)
   end subroutine enter_name

   !> Index of an object of a kind; 0 if there is none of this name.
   pure integer function find_named(model, kind, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: kind, name
      found = model%names%find(kind//' '//name)
   end function find_named

   !> Index of a body; 0 if there is none of this name.
   pure integer function find_body(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      found = find_named(model, 'body', name)
   end function find_body

   !> Index of the point that a deck names `object.point`, or `object` for the origin of its frame; 0 with a complaint if
   !> there is none.
   integer function find_point(model, name, origin, diagnostics) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      !> Where it is named
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: whole
      whole = lowercase(name)
      if (index(whole, '.') == 0) whole = whole//'.origin'
      found = find_named(model, 'point', whole)
      if (found == 0) call complain(model, lowercase(name), whole, origin, diagnostics)
   end function find_point

   !> Says that there is no such point, and what there is.
   subroutine complain(model, name, whole, origin, diagnostics)
      type(model_type), intent(in) :: model
      !> As it is written, and with its point
      character(*), intent(in) :: name, whole
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: valid, hint, object
      character(64), allocatable :: all(:)
      integer :: i, near
      hint = 'no body or ground point of this name is defined'
      ! Points of a body that is missing are missing once
      object = whole
      if (diagnostics%is_told(whole(:index(whole, '.') - 1)) .or. find_body(model, whole(:index(whole, '.') - 1)) == 0 .and. &
         & index(whole, 'ground.') /= 1) object = whole(:index(whole, '.') - 1)
      ! What is not shown need not be searched for
      if (diagnostics%count >= max_shown) then
         call diagnostics%add(origin, "there is no point '"//name//"'", hint, object=object)
         return
      end if
      allocate (all(model%counts%points))
      valid = ''
      do i = 1, size(all)
         all(i) = model%points(i)%name
         if (index(model%points(i)%name, whole(:index(whole, '.'))) /= 1) cycle
         if (valid /= '') valid = valid//', '
         valid = valid//model%points(i)%name
      end do
      if (valid /= '') then
         hint = 'valid: '//valid
      else
         near = nearest_name(whole, all)
         if (near > 0) hint = "did you mean '"//trim(all(near))//"'?"
      end if
      call diagnostics%add(origin, "there is no point '"//name//"'", hint, object=object)
   end subroutine complain

end module limber_model_points
